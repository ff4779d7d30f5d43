#pragma once

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// Where the clouds of old key frames come from. Stages never hold a container of clouds that grows
/// with the drive; they ask.
class CloudSource {
 public:
  virtual ~CloudSource() = default;
  /// The cloud in base_link of that key frame, or null if it is not known or cannot be read.
  virtual PointCloudPtr cloud(KeyFrameIndex index) = 0;
};

}  // namespace lidar_mapping
