// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Smooth hills: a sum of sine waves over the plane of the map frame.
class Terrain {
 public:
  /// Flat at height 0.
  Terrain() = default;
  /// `waves` waves with lengths between `shortest` and `longest` (m), whose steepest common slope
  /// (rise per run) is about `slope`.
  Terrain(Random random, int waves, double shortest, double longest, double slope);

  double height(const Eigen::Vector2d& at) const;
  Eigen::Vector2d gradient(const Eigen::Vector2d& at) const;
  Eigen::Vector3d on_ground(const Eigen::Vector2d& at, double above = 0.0) const;

 private:
  struct Wave {
    Eigen::Vector2d number;  ///< rad/m
    double phase;
    double amplitude;
  };
  std::vector<Wave> waves_;
};

}  // namespace lidar_mapping::simulation
