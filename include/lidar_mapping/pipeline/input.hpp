// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"

namespace lidar_mapping::pipeline {

/// A scan as it was recorded; what is costly about reading it is left to whoever needs it.
struct RecordedScan {
  Stamp stamp = 0;
  /// The cloud that is given lends its memory. Throws InputError if the data are damaged, FileError
  /// if they cannot be read.
  std::function<preprocessing::RawScan(PointCloud buffer)> decode;
};

/// A sample and the frame in whose axes it is.
template <typename Sample>
struct FramedSample {
  Sample sample;
  std::string frame_id;
};

/// One datum of a recorded drive.
using Input = std::variant<RecordedScan, FramedSample<ImuSample>, FramedSample<VelocitySample>,
                           FramedSample<GnssFix>>;

/// A recorded drive, datum by datum in the order in which they came.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// Nothing at the end. Throws FileError.
  virtual std::optional<Input> next() = 0;
  /// Goes to the first datum at or after `stamp` as deliveries count.
  virtual void skip_to(Stamp stamp) = 0;
  /// Of the whole recording.
  virtual Stamp begin() const = 0;
  virtual Stamp end() const = 0;
  /// T_base_frame, as the recording says it.
  virtual std::optional<Pose> T_base(const std::string& frame_id) const = 0;
  /// What is to be said of it since the last call: parts that are damaged, say.
  virtual std::vector<std::string> take_notices() { return {}; }
};

}  // namespace lidar_mapping::pipeline
