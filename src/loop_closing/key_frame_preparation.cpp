// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"

namespace lidar_mapping::loop_closing {

Eigen::Isometry3f isometry(const Pose& pose) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.linear() = pose.rotation_matrix().cast<float>();
  T.translation() = pose.translation.cast<float>();
  return T;
}

KeyFramePreparation::KeyFramePreparation(const LoopClosingConfig& config)
    : leaf_(config.map_leaf()) {}

PreparedKeyFrame KeyFramePreparation::prepare(const PointCloud& cloud) {
  const PointsPtr points = thinned(cloud);
  return {points, appearance_of(*points)};
}

PointsPtr KeyFramePreparation::thinned(const PointCloud& cloud) {
  return std::make_shared<const Points>(voxels_.filtered(cloud, leaf_));
}

}  // namespace lidar_mapping::loop_closing
