// SPDX-License-Identifier: BSD-3-Clause
// The prior of the first key frame.

#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"

#include "factors/drive_factors.hpp"

namespace lidar_mapping::back_end {
namespace {

/// chi2 of the first key frame's prior if the map is moved by half a metre or half a radian.
double cost_of_half(int axis, const BackEndConfig& config) {
  DriveGraph drive;
  drive.nodes.resize(2);
  drive.nodes[1].connected = true;
  drive.in_enu = {false};
  drive.segment_starts = {0};
  DriveFactors factors = make_factors(drive, config);
  Vector6d half = Vector6d::Zero();
  half[axis] = 0.5;
  const Pose moved{exp_so3(half.tail<3>()), half.head<3>()};
  factors.graph.set_pose(0, moved);
  return pose_graph::chi2(factors.graph, factors.graph.constraints.front());
}

TEST(FirstNode, HasTheConfiguredPrior) {
  BackEndConfig config;
  for (int axis = 0; axis < 6; ++axis) EXPECT_GT(cost_of_half(axis, config), 1e4) << axis;
  config.fix_first_node = true;
  // g2o's error of a rotation is the vector of the quaternion times two: of half a radian a little
  // less than that, the same for every axis.
  const double turned = cost_of_half(3, config);
  EXPECT_NEAR(turned, 0.25, 0.01);
  for (int axis = 0; axis < 6; ++axis) {
    const double expected = axis < 3 ? 0.25 : turned;
    EXPECT_NEAR(cost_of_half(axis, config), expected, 1e-9) << axis;
    config.fix_first_node_stddev[axis] = 0.1;
    for (int other = 0; other < 6; ++other) {
      const double factor = other == axis ? 100.0 : 1.0;
      EXPECT_NEAR(cost_of_half(other, config), factor * (other < 3 ? 0.25 : turned), 1e-6)
          << axis << " changed, " << other << " moved";
    }
    config.fix_first_node_stddev[axis] = 1.0;
  }
}

TEST(FirstNode, NeedsSixPositiveStandardDeviations) {
  const auto load = [](const std::string& stddev) {
    return config::load<BackEndConfig>(
        {config::parse_yaml("fix_first_node_stddev: " + stddev + "\n", "back_end.yaml")});
  };
  EXPECT_EQ(load("[10, 10, 10, 1, 1, 1]").fix_first_node_stddev[2], 10.0);
  EXPECT_THROW(load("[1, 1, 1, 1, 1]"), ConfigError);
  EXPECT_THROW(load("[1, 1, 0, 1, 1, 1]"), ConfigError);
}

}  // namespace
}  // namespace lidar_mapping::back_end
