// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/floor_detector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "lidar_mapping/common/plane_fit.hpp"
#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

#include "floor/plane_search.hpp"
#include "floor/road_surface.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// m. Chosen: half of a lane, which is 3.5 m to 4 m wide; kerbs and pavements lie beyond.
constexpr double kHalfStripWidth = 2.0;
// m, edge length of a cell whose slope is tested. Chosen: larger ones mix floor and kerb, smaller
// ones have too few points of 16 beams.
constexpr double kCellSize = 1.0;
// Points for the slope of a cell, which has three unknowns; cells with fewer are kept. Chosen.
constexpr std::size_t kMinPointsOfCell = 8;
// Ratio of the eigenvalues, middle to largest, below which the points of a cell lie on one ring
// (1:7 in breadth and length) and do not determine its slope. Chosen.
constexpr double kMaxLineRatio = 0.02;
// Sectors of 30 degrees. Chosen: wide enough that each holds points of two rings.
constexpr int kSectors = 12;
// Chosen: with fewer a narrow patch passes, with more a floor ahead fails.
constexpr int kMinSectorsOfFloor = 3;
// m from the nearest to the farthest point of a sector. Chosen: more than the foot of a wall is
// thick.
constexpr double kMinRadialExtent = 1.0;
// 1/m, of a circle of 400 m. Chosen: more than on usual streets, except where a ramp begins.
constexpr double kMaxCurvature = 1.0 / 400.0;

using Points = std::vector<Eigen::Vector3d>;

/// Fast test in single precision, with a margin, which excludes points that cannot lie on the
/// strip: most points.
class StripPrefilter {
 public:
  StripPrefilter(const Eigen::Matrix3d& R_level_base, const FloorDetectionConfig& config)
      : left_(R_level_base.row(1).cast<float>()),
        up_(R_level_base.row(2).cast<float>()),
        floor_(static_cast<float>(-config.sensor_height)),
        height_(static_cast<float>(config.height_clip_range) + kMargin) {}

  bool may_contain(const Point& p) const {
    const float y = left_.x() * p.x + left_.y() * p.y + left_.z() * p.z;
    const float z = up_.x() * p.x + up_.y() * p.y + up_.z() * p.z;
    return static_cast<int>(std::abs(y) <= kHalfWidth) &
           // a single branch, which is mostly not taken
           static_cast<int>(std::abs(z - floor_) <= height_);
  }

 private:
  // m. Chosen larger than the error of single precision at the ranges of a LiDAR.
  static constexpr float kMargin = 0.1F;
  static constexpr float kHalfWidth = static_cast<float>(kHalfStripWidth) + kMargin;

  Eigen::RowVector3f left_, up_;
  float floor_, height_;
};

/// Points on the strip that the vehicle drives on, near the expected floor, in level axes. Outside
/// of the strip there are kerbs: a plane through road and pavement would be tilted.
Points clipped(const PointCloud& cloud, const Eigen::Matrix3d& R_level_base,
               const FloorDetectionConfig& config) {
  const double radius_squared = config.floor_radius * config.floor_radius;
  const StripPrefilter strip(R_level_base, config);
  Points result;
  for (const Point& point : cloud.points) {
    if (!strip.may_contain(point)) continue;
    const Eigen::Vector3d p = R_level_base * point.position().cast<double>();
    const bool is_level = std::abs(p.z() + config.sensor_height) <= config.height_clip_range;
    if (is_level && std::abs(p.y()) <= kHalfStripWidth &&
        p.head<2>().squaredNorm() <= radius_squared)
      result.push_back(p);
  }
  return result;
}

/// True if the surface of a cell may be level. A single line of points does not decide this.
bool may_be_level(const Points& points, const std::vector<std::size_t>& cell, double max_lean) {
  if (cell.size() < kMinPointsOfCell) return true;
  PointMoments moments;
  for (const std::size_t i : cell) moments.add(points[i]);
  const PlaneFit fit(moments);
  if (fit.variances[1] < kMaxLineRatio * fit.variances[2]) return true;
  return std::abs(fit.normal.z()) >= std::cos(max_lean);
}

Points level_cells(const Points& points, double max_lean) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto cell_of = [](double coordinate) {
      return static_cast<int>(floor_to_int(coordinate / kCellSize));
    };
    cells[{cell_of(points[i].x()), cell_of(points[i].y())}].push_back(i);
  }
  Points result;
  for (const auto& [key, cell] : cells) {
    if (!may_be_level(points, cell, max_lean)) continue;
    for (const std::size_t i : cell) result.push_back(points[i]);
  }
  return result;
}

/// A floor extends outward in some directions; a ring of points on walls does not.
bool extends_outward(const Points& points, const std::vector<std::size_t>& inliers) {
  std::array<double, kSectors> nearest;
  std::array<double, kSectors> farthest;
  nearest.fill(1e9);
  farthest.fill(-1e9);
  for (const std::size_t i : inliers) {
    const double turn = (std::atan2(points[i].y(), points[i].x()) + kPi) / (2.0 * kPi);
    const auto sector =
        std::min<std::size_t>(static_cast<std::size_t>(turn * kSectors), kSectors - 1);
    const double range = points[i].head<2>().norm();
    nearest[sector] = std::min(nearest[sector], range);
    farthest[sector] = std::max(farthest[sector], range);
  }
  int wide_sectors = 0;
  for (std::size_t sector = 0; sector < kSectors; ++sector) {
    if (farthest[sector] - nearest[sector] > kMinRadialExtent) ++wide_sectors;
  }
  return wide_sectors >= kMinSectorsOfFloor;
}

Points selected(const Points& points, const std::vector<std::size_t>& indices) {
  Points result;
  result.reserve(indices.size());
  for (const std::size_t i : indices) result.push_back(points[i]);
  return result;
}

/// Converts back to base_link.
PointCloud cloud_of(const Points& points_level, const Eigen::Quaterniond& R_level_base) {
  const Eigen::Matrix3d R_base_level = R_level_base.conjugate().toRotationMatrix();
  PointCloud cloud;
  cloud.points.reserve(points_level.size());
  for (const Eigen::Vector3d& p_level : points_level) {
    const Eigen::Vector3f p = (R_base_level * p_level).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  }
  return cloud;
}

}  // namespace

FloorDetector::FloorDetector(const FloorDetectionConfig& config) : config_(config) {}

Floor FloorDetector::process(const Scan& scan, FloorPoints* output) const {
  Floor floor;
  floor.stamp = scan.stamp;
  const auto min_points = static_cast<std::size_t>(config_.floor_pts_thresh);
  const double max_lean = config_.floor_normal_thresh;
  const Eigen::Quaterniond R_level_base = exp_so3(Eigen::Vector3d(0.0, config_.tilt, 0.0));

  Points points = clipped(scan.cloud, R_level_base.toRotationMatrix(), config_);
  if (config_.use_normal_filtering) points = level_cells(points, config_.normal_filter_thresh);
  if (output != nullptr) *output = {cloud_of(points, R_level_base), {}};
  if (points.size() < min_points) return floor;
  const auto found = search_plane(points, config_.floor_distance_thresh, max_lean);
  if (!found) return floor;
  const auto fit = fit_road(points, *found, config_.floor_distance_thresh);
  if (!fit || fit->inliers.size() < min_points || !extends_outward(points, fit->inliers))
    return floor;
  const Plane below = fit->surface.tangent();
  if (below.normal.z() < std::cos(max_lean) || std::abs(fit->surface.curvature()) > kMaxCurvature) {
    return floor;
  }
  if (output != nullptr) output->inliers = cloud_of(selected(points, fit->inliers), R_level_base);
  floor.found = true;
  floor.normal = R_level_base.conjugate() * below.normal;
  floor.offset = below.offset;
  floor.covariance = fit->covariance;
  floor.inliers = static_cast<int>(fit->inliers.size());
  return floor;
}

}  // namespace lidar_mapping::preprocessing
