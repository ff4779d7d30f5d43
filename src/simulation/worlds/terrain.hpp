// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::simulation {

/// Smooth hills: a sum of sine waves over the plane of the map frame.
class Terrain {
 public:
  /// Flat at height 0.
  Terrain() = default;
  /// `waves` waves with lengths between `shortest` and `longest` (m), whose steepest common slope
  /// (rise per run) is about `slope`.
  Terrain(Random random, int waves, double shortest, double longest, double slope) {
    for (int i = 0; i < waves; ++i) {
      const double direction = random.uniform(0.0, 2.0 * kPi);
      const double number = 2.0 * kPi / random.uniform(shortest, longest);
      waves_.push_back({number * Eigen::Vector2d(std::cos(direction), std::sin(direction)),
                        random.uniform(0.0, 2.0 * kPi), slope / number / std::sqrt(waves)});
    }
  }

  double height(const Eigen::Vector2d& at) const {
    double height = 0.0;
    for (const Wave& w : waves_) height += w.amplitude * std::sin(w.number.dot(at) + w.phase);
    return height;
  }
  Eigen::Vector2d gradient(const Eigen::Vector2d& at) const {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (const Wave& w : waves_) {
      gradient += w.amplitude * std::cos(w.number.dot(at) + w.phase) * w.number;
    }
    return gradient;
  }
  Eigen::Vector3d on_ground(const Eigen::Vector2d& at, double above = 0.0) const {
    return {at.x(), at.y(), height(at) + above};
  }

 private:
  struct Wave {
    Eigen::Vector2d number;  ///< rad/m
    double phase;
    double amplitude;
  };
  std::vector<Wave> waves_;
};

}  // namespace lidar_mapping::simulation
