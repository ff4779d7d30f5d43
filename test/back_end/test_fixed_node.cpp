// SPDX-License-Identifier: BSD-3-Clause
// The prior of the first key frame.

#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"

#include "drive_factors.hpp"

namespace lidar_mapping::back_end {
namespace {

/// chi2 of the first key frame's prior if the map is moved by half a metre along x.
double cost_of_half_a_metre(const BackEndConfig& config) {
  DriveGraph drive;
  drive.nodes.resize(2);
  drive.nodes[1].connected = true;
  drive.in_enu = {false};
  drive.segment_starts = {0};
  DriveFactors factors = make_factors(drive, config);
  Pose moved;
  moved.translation.x() = 0.5;
  factors.graph.set_pose(0, moved);
  return pose_graph::chi2(factors.graph, factors.graph.constraints.front());
}

TEST(FirstNode, HasTheConfiguredPrior) {
  BackEndConfig config;
  EXPECT_GT(cost_of_half_a_metre(config), 1e5);
  config.fix_first_node = true;
  EXPECT_NEAR(cost_of_half_a_metre(config), 0.25, 1e-9);
  config.fix_first_node_stddev[0] = 0.1;
  EXPECT_NEAR(cost_of_half_a_metre(config), 25.0, 1e-6);
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
