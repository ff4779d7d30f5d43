// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::loop_closing::test {

struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// Boxes on flat floors, scanned by a spinning LiDAR 1.8 m above base_link.
class ToyWorld {
 public:
  std::vector<Box> boxes;
  std::vector<double> floors = {0.0};  ///< heights, m
  int beams = 16;
  double lowest = -15.0;  ///< elevation of a beam, degrees
  double highest = 15.0;
  double range = 60.0;

  static Eigen::Vector3d sensor() { return {0.0, 0.0, 1.8}; }

  /// A scan in base_link, with noise of 2 cm from `seed`.
  PointCloud scan(const Pose& T_world_base, std::uint32_t seed) const {
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise(0.0, 0.02);
    const Eigen::Vector3d origin = T_world_base * sensor();
    const std::vector<Box> near = boxes_near(origin);
    PointCloud cloud;
    for (int beam = 0; beam < beams; ++beam) {
      const double elevation = (lowest + (highest - lowest) * beam / (beams - 1)) * kPi / 180.0;
      for (int step = 0; step < kSteps; ++step) {
        const double azimuth = 2.0 * kPi * step / kSteps;
        const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                                  std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
        const double distance = cast(origin, T_world_base.rotation * ray, near);
        if (distance >= range) continue;
        const Eigen::Vector3d p = sensor() + ray * (distance + noise(generator));
        cloud.points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                                static_cast<float>(p.z()), 0.0F});
      }
    }
    return cloud;
  }

 private:
  static constexpr int kSteps = 360;

  std::vector<Box> boxes_near(const Eigen::Vector3d& origin) const {
    std::vector<Box> near;
    for (const Box& box : boxes) {
      const Eigen::Vector3d nearest = origin.cwiseMax(box.low).cwiseMin(box.high);
      if ((nearest - origin).norm() < range) near.push_back(box);
    }
    return near;
  }

  double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray,
              const std::vector<Box>& near) const {
    double nearest = range;
    for (const double floor : floors) {
      const double distance = (floor - origin.z()) / ray.z();
      if (distance > 0.0) nearest = std::min(nearest, distance);
    }
    for (const Box& box : near) {
      const Eigen::Array3d a = (box.low - origin).array() / ray.array();
      const Eigen::Array3d b = (box.high - origin).array() / ray.array();
      const double enter = a.min(b).maxCoeff();
      if (enter > 0.0 && enter <= a.max(b).minCoeff()) nearest = std::min(nearest, enter);
    }
    return nearest;
  }
};

/// The same world for a LiDAR that sees the ground and what is low, as many sensors of vehicles do.
inline ToyWorld seen_downwards(ToyWorld world) {
  world.beams = 32;
  world.lowest = -25.0;
  world.highest = 2.0;
  return world;
}

/// Streets along x and y every `block` metres, with houses of different sizes between them.
inline ToyWorld make_town(double extent, double block, std::uint32_t seed) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator);
  };
  ToyWorld world;
  for (double x = -extent; x < extent; x += 12.0) {
    for (double y = -extent; y < extent; y += 12.0) {
      const Eigen::Vector3d low(x + uniform(0.0, 4.0), y + uniform(0.0, 4.0), 0.0);
      const Eigen::Vector3d size(uniform(2.0, 9.0), uniform(2.0, 9.0), uniform(1.0, 9.0));
      const Eigen::Vector3d high = low + size;
      const auto blocks_street = [&](double a, double b) {
        const double street = std::round((a + b) / 2.0 / block) * block;
        return a < street + 6.0 && b > street - 6.0;
      };
      if (blocks_street(low.x(), high.x()) || blocks_street(low.y(), high.y())) continue;
      world.boxes.push_back({low, high});
    }
  }
  return world;
}

/// A planar pose with a heading in rad.
inline Pose planar(double x, double y, double heading, double z = 0.0) {
  Pose pose;
  pose.translation = {x, y, z};
  pose.rotation = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ());
  return pose;
}

/// Poses every `step` metres along the corners, heading forward.
inline std::vector<Pose> along(const std::vector<Eigen::Vector2d>& corners, double step = 2.0) {
  std::vector<Pose> poses;
  double remaining = 0.0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d side = corners[i + 1] - corners[i];
    double s = remaining;
    for (; s < side.norm(); s += step) {
      const Eigen::Vector2d p = corners[i] + side.normalized() * s;
      poses.push_back(planar(p.x(), p.y(), std::atan2(side.y(), side.x())));
    }
    remaining = s - side.norm();
  }
  return poses;
}

/// The true poses with a scale error and a heading error per metre, like those of odometry.
inline std::vector<Pose> drifting(const std::vector<Pose>& truth, double scale,
                                  double rad_per_metre, double climb_per_metre = 0.0) {
  std::vector<Pose> odometry = {truth.front()};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Pose step = truth[i - 1].inverse() * truth[i];
    const double length = step.translation.norm();
    step.translation *= scale;
    step.translation.z() += climb_per_metre * length;
    step.rotation =
        step.rotation * Eigen::AngleAxisd(rad_per_metre * length, Eigen::Vector3d::UnitZ());
    odometry.push_back(odometry.back() * step);
  }
  return odometry;
}

/// Simulates the scans of a drive on demand; key frame i is at poses[i].
class DriveClouds : public CloudSource {
 public:
  DriveClouds(const ToyWorld& world, std::vector<Pose> poses)
      : world_(world), poses_(std::move(poses)) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    if (index >= poses_.size()) return nullptr;
    return std::make_shared<const PointCloud>(world_.scan(poses_[index], index));
  }

 private:
  const ToyWorld& world_;
  std::vector<Pose> poses_;
};

}  // namespace lidar_mapping::loop_closing::test
