// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/moving_points.hpp"

#include <algorithm>
#include <vector>

#include <Eigen/Geometry>

#include "local_map/local_map.hpp"
#include "local_map/marked_planes.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A view is kept every so many metres. Chosen: a truck that drives alongside has then moved on by
/// more than the margin of a FreeSpaceImage.
constexpr double kViewDistance = 5.0;
/// With kViewDistance they reach back by 25 m. Chosen: farther than a truck with its trailer is
/// long, so that all of it is where one of them saw free space.
constexpr std::size_t kViews = 5;
/// m. A view tells nothing of points farther from it. Chosen: there a cell of its image is as wide
/// as a post, which may have been missed.
constexpr float kMaxRange = 30.0F;
/// One of so many points is tested first, and all of them only if so many of these move. Chosen: so
/// the test takes a tenth of the time where nothing moves, and a truck at 10 m, which is one in a
/// hundred of the points, is still found.
constexpr std::size_t kFirstLookStride = 8;
constexpr std::ptrdiff_t kFirstLookPoints = 2;
/// Fraction of the points from which on they are left out. Measured: cars that pass are up to 0.03
/// of the points, and without them poses are no better (a ratio of 0.996 on sixty drives); a truck
/// alongside is 0.08 and more.
constexpr double kMinFraction = 0.05;

/// Transforms points that are given relative to `origin`, in the axes of the map, into a view.
Eigen::Isometry3f into_view(const Pose& T_map_sensor, const Eigen::Vector3d& origin) {
  Eigen::Isometry3d T_sensor_origin(T_map_sensor.inverse().matrix());
  T_sensor_origin.translation() = T_sensor_origin * origin;
  return Eigen::Isometry3f(T_sensor_origin.matrix().cast<float>());
}

}  // namespace

void MovingPointFinder::add_view(const SampledPoints& points, const MotionState& motion) {
  const Eigen::Vector3d& position = motion.T_map_sensor.translation;
  if (!views_.empty() &&
      (position - views_.back().T_map_sensor.translation).norm() < kViewDistance) {
    return;
  }
  SampledPoints measured;
  transform_points(points, motion, position, measured);
  const Eigen::Isometry3f T_sensor_origin = into_view(motion.T_map_sensor, position);
  std::vector<Eigen::Vector3f> seen(points.size());
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = T_sensor_origin * measured.position(i);
  views_.push_back({motion.T_map_sensor, FreeSpaceImage(seen, Eigen::Vector3f::Zero())});
  if (views_.size() > kViews) views_.pop_front();
}

PointMarks MovingPointFinder::find(const SampledPoints& points, const MotionState& motion) const {
  if (views_.empty()) return {};
  const Eigen::Vector3d& origin = motion.T_map_sensor.translation;
  SampledPoints measured;
  transform_points(points, motion, origin, measured);
  PointMarks marks(points.size(), 0);
  const auto mark_every = [&](std::size_t stride) {
    for (const View& view : views_) {
      const Eigen::Isometry3f T_view_origin = into_view(view.T_map_sensor, origin);
      for (std::size_t i = 0; i < marks.size(); i += stride) {
        if (marks[i] != 0) continue;
        const Eigen::Vector3f p = T_view_origin * measured.position(i);
        if (p.squaredNorm() > kMaxRange * kMaxRange) continue;
        marks[i] = view.image.is_certain_violation(p) ? 1 : 0;
      }
    }
  };
  mark_every(kFirstLookStride);
  if (std::count(marks.begin(), marks.end(), 1) < kFirstLookPoints) return {};
  mark_every(1);
  mark_planes(measured, marks);
  const auto moving = static_cast<double>(std::count(marks.begin(), marks.end(), 1));
  if (moving < kMinFraction * static_cast<double>(marks.size())) return {};
  return marks;
}

}  // namespace lidar_mapping::front_end
