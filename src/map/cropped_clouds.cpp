// SPDX-License-Identifier: BSD-3-Clause
#include "cropped_clouds.hpp"

#include <memory>
#include <optional>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/map/write_products.hpp"

namespace lidar_mapping::map {

std::optional<Eigen::AlignedBox3d> crop_box(const std::vector<double>& corners) {
  if (corners.empty()) return std::nullopt;
  if (corners.size() != 6) {
    throw InputError("a box has six numbers, x0 y0 z0 x1 y1 z1 in m; there are " +
                     std::to_string(corners.size()));
  }
  const Eigen::AlignedBox3d box(Eigen::Vector3d(corners.data()), Eigen::Vector3d(&corners[3]));
  if (!(box.min().array() < box.max().array()).all()) {
    throw InputError(text_of(box) + " is empty; give the lower corner first, x0 y0 z0 x1 y1 z1");
  }
  return box;
}

std::string text_of(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d &low = box.min(), &high = box.max();
  return formatted("the box from (%g, %g, %g) to (%g, %g, %g)", low.x(), low.y(), low.z(), high.x(),
                   high.y(), high.z());
}

CroppedClouds::CroppedClouds(CloudSource& clouds, const KeyFramePoses& poses,
                             const Eigen::AlignedBox3d& box)
    : clouds_(clouds), box_(box) {
  for (const KeyFramePose& pose : poses.poses) poses_[pose.index] = pose.T_map_base;
}

PointCloudPtr CroppedClouds::cloud(KeyFrameIndex index) {
  return cropped(clouds_.cloud(index), index);
}

std::vector<PointCloudPtr> CroppedClouds::clouds(const std::vector<KeyFrameIndex>& indices,
                                                 int threads) {
  std::vector<PointCloudPtr> found = clouds_.clouds(indices, threads);
  for (std::size_t i = 0; i < found.size(); ++i) found[i] = cropped(found[i], indices[i]);
  return found;
}

PointCloudPtr CroppedClouds::cropped(const PointCloudPtr& cloud, KeyFrameIndex index) const {
  const auto pose = poses_.find(index);
  if (!cloud || pose == poses_.end()) return nullptr;
  auto inside = std::make_shared<PointCloud>();
  for (const Point& point : cloud->points) {
    if (box_.contains(pose->second * point.position().cast<double>())) {
      inside->points.push_back(point);
    }
  }
  return inside;
}

}  // namespace lidar_mapping::map
