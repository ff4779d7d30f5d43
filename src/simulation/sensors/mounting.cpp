// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/mounting.hpp"

namespace lidar_mapping::simulation {

namespace {

Pose mounted(const Eigen::Vector3d& at, const Eigen::Vector3d& turned_rad) {
  return {exp_so3(turned_rad), at};
}

}  // namespace

SensorMounting car_mounting() {
  return {mounted({0.76, 0.02, 1.73}, {0.006, 0.009, -0.012}),
          mounted({-0.05, 0.32, 0.93}, {-0.004, 0.003, 0.02}),
          {-0.35, 0.45, 1.52}};
}

SensorMounting hand_held_mounting() {
  return {mounted({0.02, 0.01, 0.3}, {0.004, -0.012, 0.02}),
          mounted({0.01, -0.02, 0.18}, {0.003, 0.004, -0.015}),
          {0.0, 0.05, 0.45}};
}

SensorMounting legged_mounting() {
  return {mounted({0.18, 0.0, 0.16}, {0.005, 0.012, -0.008}),
          mounted({0.02, 0.01, 0.04}, {-0.006, 0.002, 0.01}),
          {-0.15, 0.0, 0.2}};
}

SensorMounting drone_mounting() {
  return {mounted({0.03, 0.0, 0.12}, {-0.004, 0.008, 0.015}),
          mounted({0.0, 0.01, 0.03}, {0.005, -0.003, -0.02}),
          {-0.1, 0.0, 0.15}};
}

}  // namespace lidar_mapping::simulation
