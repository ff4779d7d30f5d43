// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::moving_objects {

/// An axis-parallel box in the map frame, m.
struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;

  bool contains(const Eigen::Vector3d& p, double margin) const {
    return ((p - low).array() > -margin).all() && ((high - p).array() > -margin).all();
  }
};

/// Distance along a ray to a box; infinity if it misses.
inline double distance_to(const Box& box, const Eigen::Vector3d& origin,
                          const Eigen::Vector3d& ray) {
  double near = 0.0;
  double far = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.low[i] - origin[i]) / ray[i];
    const double b = (box.high[i] - origin[i]) / ray[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far && near > 0.0 ? near : std::numeric_limits<double>::infinity();
}

/// Ground, the walls on both sides of a street along x, and a pole.
inline std::vector<Box> street_boxes() {
  return {{{-50.0, 8.0, 0.0}, {80.0, 9.0, 8.0}},
          {{-50.0, -9.0, 0.0}, {80.0, -8.0, 8.0}},
          {{20.0, 6.0, 0.0}, {20.15, 6.15, 5.0}},
          {{-60.0, -60.0, -1.0}, {100.0, 60.0, 0.0}}};
}

/// What a LiDAR of 48 beams sees of boxes, in base_link.
inline PointCloudPtr scan_of_boxes(const std::vector<Box>& boxes, const Pose& T_map_base,
                                   const Eigen::Vector3d& p_base_sensor) {
  auto cloud = std::make_shared<PointCloud>();
  const Eigen::Vector3d origin = T_map_base * p_base_sensor;
  for (int beam = 0; beam < 48; ++beam) {
    const double elevation = (-24.0 + 0.6 * beam) * M_PI / 180.0;
    for (int column = 0; column < 720; ++column) {
      const double azimuth = column * M_PI / 360.0 + 1e-4;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = std::numeric_limits<double>::infinity();
      for (const Box& box : boxes) range = std::min(range, distance_to(box, origin, ray));
      if (range > 60.0) continue;
      const Eigen::Vector3f p = (T_map_base.inverse() * (origin + range * ray)).cast<float>();
      cloud->points.push_back({p.x(), p.y(), p.z(), 1.0F});
    }
  }
  return cloud;
}

/// A drive along the street on one day and on the next; on one of them a car is parked there.
class TwoDays : public CloudSource {
 public:
  TwoDays(KeyFrameIndex key_frames_of_day, double spacing, const Box& car, bool is_next_day_parked)
      : key_frames_of_day_(key_frames_of_day), car_(car), is_next_day_parked_(is_next_day_parked) {
    for (KeyFrameIndex index = 0; index < 2 * key_frames_of_day; ++index) {
      Pose pose;
      pose.translation.x() = spacing * (index % key_frames_of_day);
      poses.poses.push_back(
          {index, from_seconds(index + (is_next_day(index) ? 86'400.0 : 0.0)), pose});
    }
  }
  PointCloudPtr cloud(KeyFrameIndex index) override {
    std::vector<Box> boxes = street_boxes();
    if (is_next_day(index) == is_next_day_parked_) boxes.push_back(car_);
    return scan_of_boxes(boxes, poses.poses[index].T_map_base, p_base_sensor);
  }

  const Eigen::Vector3d p_base_sensor{0.5, 0.0, 1.8};
  KeyFramePoses poses;

 private:
  bool is_next_day(KeyFrameIndex index) const { return index >= key_frames_of_day_; }

  KeyFrameIndex key_frames_of_day_;
  Box car_;
  bool is_next_day_parked_;
};

}  // namespace lidar_mapping::moving_objects
