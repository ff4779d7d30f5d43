// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::test {

/// A street corner 30 m across: ground, two walls with bays, a slope and poles. The points lie at
/// random places of the surfaces, `noise` (m) beside them; another seed draws other points of the
/// same surfaces.
inline PointCloud street_corner(unsigned seed, std::size_t points, double noise) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> error(0.0, noise);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  PointCloud cloud;
  while (cloud.size() < points) {
    Eigen::Vector3d p;
    const double kind = unit(engine);
    if (kind < 0.4) {  // ground, rising behind x = 6
      p = {between(-15.0, 15.0), between(-15.0, 15.0), 0.0};
      p.z() = -1.7 + 0.08 * std::max(0.0, p.x() - 6.0);
    } else if (kind < 0.6) {  // wall along x with bays
      p = {between(-15.0, 15.0), 7.3, between(-1.7, 4.0)};
      p.y() += std::fmod(p.x() + 60.0, 8.0) < 3.0 ? 1.5 : 0.0;
    } else if (kind < 0.75) {  // wall along y
      p = {12.4, between(-15.0, 7.3), between(-1.0, 5.0)};
      p.x() += std::fmod(p.y() + 60.0, 11.0) < 4.0 ? 2.0 : 0.0;
    } else if (kind < 0.9) {  // oblique wall
      const double along = between(0.0, 15.0);
      p = {-13.0 + 0.9 * along, -8.0 - 0.4 * along, between(-1.7, 4.0)};
    } else {  // poles
      const int pole = static_cast<int>(between(0.0, 8.0));
      const double angle = between(0.0, 2.0 * M_PI);
      p = {-12.0 + 3.3 * pole + 0.15 * std::cos(angle),
           -4.0 + 2.0 * (pole % 3) + 0.15 * std::sin(angle), between(-1.7, 3.5)};
    }
    p += Eigen::Vector3d(error(engine), error(engine), error(engine));
    cloud.points.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F});
  }
  return cloud;
}

}  // namespace lidar_mapping::test
