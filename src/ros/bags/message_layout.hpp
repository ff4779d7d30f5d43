// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace lidar_mapping::ros_border {

/// How a field of a message lies on the wire.
struct MessageField {
  enum class Kind { kNumber, kText, kTime, kSequenceNumber, kMessage };
  enum class Count { kOne, kFixed, kAny };

  Kind kind = Kind::kNumber;
  Count count = Count::kOne;
  std::size_t size = 0;      ///< bytes of a number
  std::size_t elements = 0;  ///< of a fixed array
  std::string type;          ///< of a message: a key of MessageLayout::messages
};

/// The layout of a type of message, from its definition as bags have it: the fields, and below them
/// the definitions of the messages in them. kSequenceNumber is header.seq, which ROS 2 lacks.
struct MessageLayout {
  std::vector<MessageField> fields;
  std::map<std::string, std::vector<MessageField>> messages;
};

/// Reads a definition. It is one of this package or of ROS itself, so that it is not checked.
MessageLayout message_layout(const std::string& definition);

}  // namespace lidar_mapping::ros_border
