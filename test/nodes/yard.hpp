// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::test {

/// Stamps of scans, ten in a second.
constexpr Stamp kBegin = 1317384506123456789;
constexpr Stamp kPeriod = 100000000;

inline Stamp stamp_of(int step) { return kBegin + step * kPeriod; }

/// A walled yard with pillars, as seen from a vehicle in it: enough structure for any matching.
inline PointCloud yard_seen_from(const Pose& T_map_base, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> along(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  const Pose T_base_map = T_map_base.inverse();
  PointCloud cloud;
  const auto add = [&](double x, double y, double z) {
    const Eigen::Vector3d p_map(x + noise(random), y + noise(random), z + noise(random));
    const Eigen::Vector3f p = (T_base_map * p_map).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), 0.5F});
  };
  for (int i = 0; i < 8000; ++i) add(50.0 * along(random) - 15.0, 24.0 * along(random) - 12.0, 0.0);
  for (int i = 0; i < 3000; ++i) {
    const double z = 5.0 * along(random);
    add(50.0 * along(random) - 15.0, i % 2 == 0 ? 12.0 : -12.0, z);
    add(i % 2 == 0 ? -15.0 : 35.0, 24.0 * along(random) - 12.0, z);
    const double angle = 2.0 * M_PI * along(random);
    const int pillar = i % 6;
    add(-10.0 + 8.0 * pillar + 0.8 * std::cos(angle),
        (pillar % 2 == 0 ? 6.0 : -7.0) + 0.8 * std::sin(angle), z);
  }
  return cloud;
}

/// The pose `step` of a straight drive at `speed` metres per step.
inline Pose straight(int step, double speed = 0.5) {
  return {Eigen::Quaterniond::Identity(), {speed * step, 0.0, 1.0}};
}

}  // namespace lidar_mapping::test
