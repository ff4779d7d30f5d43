#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>

#include <Eigen/Core>

namespace lidar_mapping::map {

/// Sums over the points of a cell.
struct Moments {
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& point) {
    count += 1.0;
    sum += point;
    squares += point * point.transpose();
  }
  Eigen::Vector3d mean() const { return sum / count; }
  Eigen::Matrix3d covariance() const { return squares / count - mean() * mean().transpose(); }
};

struct Plane {
  Eigen::Vector3d normal;
  Eigen::Vector3d centre;
  double thickness = 0.0;  ///< standard deviation along the normal, m
  double extent = 0.0;     ///< second largest standard deviation, m
};

Plane plane_of(const Moments& moments);

inline bool is_ground(const Plane& plane) { return std::abs(plane.normal.z()) > 0.9; }
inline bool is_wall(const Plane& plane) { return std::abs(plane.normal.z()) < 0.25; }

/// Key of the cell of edge `size` that a point lies in.
std::int64_t cell_key(const Eigen::Vector3d& point, double size);

}  // namespace lidar_mapping::map
