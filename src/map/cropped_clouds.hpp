// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::map {

/// "the box from (x, y, z) to (x, y, z)", in m.
std::string text_of(const Eigen::AlignedBox3d& box);

/// The parts of the clouds that lie in a box of the map.
class CroppedClouds : public CloudSource {
 public:
  /// `clouds` must outlive this object. Key frames without a pose have no cloud.
  CroppedClouds(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::AlignedBox3d& box);

  PointCloudPtr cloud(KeyFrameIndex index) override;
  std::vector<PointCloudPtr> clouds(const std::vector<KeyFrameIndex>& indices,
                                    int threads) override;

 private:
  PointCloudPtr cropped(const PointCloudPtr& cloud, KeyFrameIndex index) const;

  CloudSource& clouds_;
  const Eigen::AlignedBox3d box_;
  std::map<KeyFrameIndex, Pose> poses_;
};

}  // namespace lidar_mapping::map
