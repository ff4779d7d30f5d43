// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/parallel.hpp"

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

/// A source whose cloud() may be called by several threads at once.
class ParallelCloudSource : public CloudSource {
 public:
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override {
    std::vector<PointCloudPtr> found(indices.size());
    parallel_chunks(indices.size(), 1, threads,
                    [&](std::size_t i, std::size_t) { found[i] = cloud(indices[i]); });
    return found;
  }
};

}  // namespace lidar_mapping
