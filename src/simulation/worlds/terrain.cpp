// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/terrain.hpp"

#include <cmath>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::simulation {

Terrain::Terrain(Random random, int waves, double shortest, double longest, double slope) {
  for (int i = 0; i < waves; ++i) {
    const double direction = random.uniform(0.0, 2.0 * kPi);
    const double number = 2.0 * kPi / random.uniform(shortest, longest);
    waves_.push_back({number * Eigen::Vector2d(std::cos(direction), std::sin(direction)),
                      random.uniform(0.0, 2.0 * kPi), slope / number / std::sqrt(waves)});
  }
}

double Terrain::height(const Eigen::Vector2d& at) const {
  double height = 0.0;
  for (const Wave& w : waves_) height += w.amplitude * std::sin(w.number.dot(at) + w.phase);
  return height;
}

Eigen::Vector2d Terrain::gradient(const Eigen::Vector2d& at) const {
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  for (const Wave& w : waves_) {
    gradient += w.amplitude * std::cos(w.number.dot(at) + w.phase) * w.number;
  }
  return gradient;
}

Eigen::Vector3d Terrain::on_ground(const Eigen::Vector2d& at, double above) const {
  return {at.x(), at.y(), height(at) + above};
}

}  // namespace lidar_mapping::simulation
