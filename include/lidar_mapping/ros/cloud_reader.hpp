// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/preprocessing/hesai_packets.hpp"
#include "lidar_mapping/preprocessing/velodyne_packets.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// Decodes clouds of all cloud_types(): points as decode() does, packets of sensors by their
/// formats. Any thread may call it.
class CloudReader {
 public:
  /// Reads the calibrations of sensors that the configuration names. Throws FileError or
  /// ConfigError if such a file cannot be used.
  explicit CloudReader(const preprocessing::PreprocessingConfig& config);

  /// Points and times. Throws InputError as decode(), preprocessing::VelodyneDecoder and
  /// preprocessing::HesaiDecoder do.
  DecodedCloud read(const RecordedCloud& cloud) const;
  /// The same, but points of the usual layout stay packed, as decode_lazily() leaves them. The
  /// memory of `buffer` is used again.
  DecodedCloud read_lazily(const RecordedCloud& cloud, PointCloud buffer = {}) const;

 private:
  DecodedCloud read_packets(const RecordedCloud& cloud, PointCloud buffer) const;

  preprocessing::PreprocessingConfig config_;
  preprocessing::VelodyneDecoder velodyne_;
  preprocessing::HesaiDecoder hesai_;
};

}  // namespace lidar_mapping::ros_border
