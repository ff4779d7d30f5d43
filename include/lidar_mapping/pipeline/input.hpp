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

/// A recorded scan. The expensive part of reading it is postponed until decode() is called.
struct RecordedScan {
  Stamp stamp = 0;  ///< Stamp of the recording, ns.
  /// Reads the points; the memory of `buffer` is reused. Throws InputError if the data are damaged,
  /// FileError if they cannot be read.
  std::function<preprocessing::RawScan(PointCloud buffer)> decode;
};

/// A sample of a sensor with the frame in whose axes it is measured.
template <typename Sample>
struct FramedSample {
  Sample sample;         ///< Measurement with its stamp.
  std::string frame_id;  ///< Name of the frame.
};

/// One datum of a recorded drive: a scan or a sample of another sensor.
using Input = std::variant<RecordedScan, FramedSample<ImuSample>, FramedSample<VelocitySample>,
                           FramedSample<GnssFix>>;

/// A recorded drive, read datum by datum in the order in which the data were delivered.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// The next datum; none at the end. Throws FileError.
  virtual std::optional<Input> next() = 0;
  /// Continues with the first datum that was delivered at or after `stamp`. This and the next times
  /// are by the clock of the scans' stamps, which need not be that of the recorder.
  virtual void skip_to(Stamp stamp) = 0;
  /// Time of the first datum of the whole recording, ns.
  virtual Stamp begin() const = 0;
  /// Time of the last datum of the whole recording, ns.
  virtual Stamp end() const = 0;
  /// Pose T_base_frame as the recording states it; none if it does not know the frame.
  virtual std::optional<Pose> T_base(const std::string& frame_id) const = 0;
  /// Messages about the recording since the last call, for instance about damaged parts.
  virtual std::vector<std::string> take_messages() { return {}; }
};

}  // namespace lidar_mapping::pipeline
