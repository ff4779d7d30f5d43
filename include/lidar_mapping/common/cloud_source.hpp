// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// Where the clouds of old key frames come from. Stages never hold a container of clouds that grows
/// with the drive; they ask.
class CloudSource {
 public:
  virtual ~CloudSource() = default;
  /// The cloud in base_link of that key frame, or null if it is not known or cannot be read.
  virtual PointCloudPtr cloud(KeyFrameIndex index) = 0;
  /// The clouds of several key frames in that order, null where cloud() would give null. The second
  /// argument is the greatest number of threads (0: all cores) for sources that can be asked by
  /// more than one.
  virtual std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                            int /*threads*/) {
    std::vector<PointCloudPtr> found;
    found.reserve(indices.size());
    for (const KeyFrameIndex index : indices) found.push_back(cloud(index));
    return found;
  }
};

}  // namespace lidar_mapping
