// SPDX-License-Identifier: BSD-3-Clause
#include "bags/message_layout.hpp"

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace lidar_mapping::ros_border {

namespace {

using Kind = MessageField::Kind;
using Count = MessageField::Count;

/// Bytes of the numbers of message definitions, by wiki.ros.org/msg.
const std::map<std::string, std::size_t> kNumbers = {
    {"bool", 1},  {"byte", 1},   {"char", 1},   {"int8", 1},   {"uint8", 1},
    {"int16", 2}, {"uint16", 2}, {"int32", 4},  {"uint32", 4}, {"float32", 4},
    {"int64", 8}, {"uint64", 8}, {"float64", 8}};

/// "Header" and "geometry_msgs/Vector3" without the package: within a definition they are unique.
std::string short_name(const std::string& type) { return type.substr(type.find_last_of('/') + 1); }

/// Takes "[3]" or "[]" off the type.
void set_count(std::string& type, MessageField& field) {
  const std::size_t open = type.find('[');
  if (open == std::string::npos) return;
  field.elements = std::strtoul(type.c_str() + open + 1, nullptr, 10);
  field.count = field.elements > 0 ? Count::kFixed : Count::kAny;
  type.erase(open);
}

MessageField field_of(std::string type, const std::string& name, const std::string& message) {
  MessageField field;
  set_count(type, field);
  const auto number = kNumbers.find(type);
  if (number != kNumbers.end()) {
    field.size = number->second;
    if (message == "Header" && name == "seq") field.kind = Kind::kSequenceNumber;
  } else if (type == "string") {
    field.kind = Kind::kText;
  } else if (type == "time" || type == "duration") {
    field.kind = Kind::kTime;
  } else {
    field.kind = Kind::kMessage;
    field.type = short_name(type);
  }
  return field;
}

}  // namespace

MessageLayout message_layout(const std::string& definition) {
  MessageLayout layout;
  std::vector<MessageField>* fields = &layout.fields;
  std::string message;
  std::istringstream lines(definition);
  for (std::string line; std::getline(lines, line);) {
    line.erase(line.begin() + static_cast<std::ptrdiff_t>(std::min(line.find('#'), line.size())),
               line.end());
    std::istringstream words(line);
    std::string type, name;
    if (!(words >> type >> name) || line.find('=') != std::string::npos) continue;  // a constant
    if (type == "MSG:") {
      message = short_name(name);
      fields = &layout.messages[message];
    } else {
      fields->push_back(field_of(type, name, message));
    }
  }
  return layout;
}

}  // namespace lidar_mapping::ros_border
