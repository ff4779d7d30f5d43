// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "drive/drive_results.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

/// Five segments of two key frames each, with gaps in their indices; by odometry a metre apart.
DriveGraph five_segments() {
  DriveGraph drive;
  for (int i = 0; i < 10; ++i) {
    DriveNode node;
    node.index = static_cast<KeyFrameIndex>(10 + 3 * i);
    node.segment = i / 2;
    node.connected = i % 2 == 1;
    node.stamp = from_seconds(100.0 + i);
    node.T_odom_base.translation.x() = i;
    node.T_map_base = node.T_odom_base;
    drive.nodes.push_back(node);
  }
  drive.in_enu.assign(5, false);
  drive.gnss_delays.assign(5, GnssDelay{0.0, 0.0});
  return drive;
}

void add_loop(DriveGraph& drive, int from, int to, bool used, bool evaluated) {
  DriveLoop loop;
  loop.loop.from = drive.nodes[from].index;
  loop.loop.to = drive.nodes[to].index;
  loop.loop.T_from_to.translation.x() = to - from;
  loop.from = from;
  loop.to = to;
  loop.used = used;
  loop.evaluated = evaluated;
  drive.loops.push_back(loop);
}

TEST(DriveResults, PosesAreThoseOfTheGraph) {
  DriveGraph drive = five_segments();
  drive.nodes[3].T_map_base.translation.y() = 8.0;
  const KeyFramePoses poses = poses_of(drive, 6);
  EXPECT_EQ(poses.revision, 6U);
  EXPECT_TRUE(poses.whole);
  ASSERT_EQ(poses.poses.size(), 10U);
  EXPECT_EQ(poses.poses[3].index, 19U);
  EXPECT_EQ(poses.poses[3].stamp, from_seconds(103.0));
  EXPECT_EQ(poses.poses[3].T_map_base.translation, Eigen::Vector3d(3.0, 8.0, 0.0));
}

TEST(DriveResults, OdometryBeginsWhereTheMapDoes) {
  DriveGraph drive = five_segments();
  const Pose first{exp_so3({0.0, 0.0, kPi / 2.0}), {50.0, 20.0, 1.0}};
  drive.nodes[0].T_odom_base.translation.z() = 2.0;
  drive.nodes[0].T_map_base = first;
  drive.nodes[9].T_map_base.translation.x() = -1000.0;
  const KeyFramePoses odometry = odometry_of(drive, 6);
  EXPECT_TRUE(test::near(odometry.poses[0].T_map_base, first, 1e-9));
  EXPECT_TRUE(
      test::near(odometry.poses[9].T_map_base, Pose{first.rotation, {50.0, 29.0, -1.0}}, 1e-9));
  EXPECT_TRUE(odometry_of(DriveGraph(), 6).poses.empty());
}

TEST(DriveResults, LoopsAreUsedUntilTheyAreRefused) {
  DriveGraph drive = five_segments();
  add_loop(drive, 0, 4, true, true);
  add_loop(drive, 1, 5, false, true);
  add_loop(drive, 2, 6, false, false);
  const auto loops = loops_of(drive);
  ASSERT_EQ(loops.size(), 3U);
  EXPECT_TRUE(loops[0].second);
  EXPECT_FALSE(loops[1].second);
  EXPECT_TRUE(loops[2].second) << "not evaluated yet";
  EXPECT_EQ(loops[1].first.to, 25U);
}

TEST(DriveResults, PartsAreConnectedByLoopsOrByEastNorthUp) {
  DriveGraph drive = five_segments();
  add_loop(drive, 2, 5, true, true);
  add_loop(drive, 0, 3, false, false);
  EXPECT_EQ(parts_of(drive), (std::vector<int>{0, 0, 1, 1, 1, 1, 3, 3, 4, 4}));
  drive.in_enu[2] = drive.in_enu[4] = true;
  EXPECT_EQ(parts_of(drive), (std::vector<int>{0, 0, 1, 1, 1, 1, 3, 3, 1, 1}))
      << "the third one and the last one lie in one frame";
}

TEST(DriveResults, PositionsHaveTheDelayOfTheirSegment) {
  DriveGraph drive = five_segments();
  for (const int node : {1, 3}) {
    DriveGnss gnss;
    gnss.node = node;
    gnss.position.stamp = drive.nodes[node].stamp;
    gnss.position.p_base_antenna = {0.0, 0.0, 2.0};
    drive.gnss.push_back(gnss);
  }
  drive.gnss_delays[1].seconds = 0.25;
  const std::vector<GnssPosition> positions = positions_of(drive);
  ASSERT_EQ(positions.size(), 2U);
  EXPECT_TRUE(test::near(positions[0].p_base_antenna, Eigen::Vector3d(0.0, 0.0, 2.0), 1e-9));
  EXPECT_TRUE(test::near(positions[1].p_base_antenna, Eigen::Vector3d(-0.25, 0.0, 2.0), 1e-9))
      << "at 1 m/s, a quarter of a second before";
}

TEST(DriveResults, TheGraphHasTheMotionsAndTheLoopsThatAreUsed) {
  DriveGraph drive = five_segments();
  drive.odometry_errors.scale_error = 0.1;
  add_loop(drive, 0, 4, false, true);
  add_loop(drive, 1, 5, false, false);
  add_loop(drive, 2, 6, true, true);
  drive.loops[2].loop.covariance = diagonal_covariance(2.0, 0.5);
  BackEndConfig config;
  config.loop_min_stddev_m = config.loop_min_stddev_rad = 0.0;
  config.odometry_min_stddev_m = config.odometry_min_stddev_rad = 0.0;
  config.odometry_drift = config.odometry_rotation_drift = 0.0;
  const pose_graph::PoseGraph graph = pose_graph_of(drive, config);
  EXPECT_FALSE(graph.planar);
  ASSERT_EQ(graph.nodes.size(), 10U);
  EXPECT_EQ(graph.nodes[9].id, 37);
  ASSERT_EQ(graph.edges.size(), 6U) << "a motion in each segment, and one loop";
  EXPECT_EQ(graph.edges[1].from, 16);
  EXPECT_EQ(graph.edges[1].to, 19);
  EXPECT_NEAR(graph.edges[1].T_from_to.translation.x(), 1.1, 1e-12);
  EXPECT_NEAR(graph.edges[1].information(0, 0), 1.0, 1e-9);
  EXPECT_NEAR(graph.edges[1].information(3, 3), 4.0, 1e-9) << "of half angles";
  EXPECT_EQ(graph.edges[5].from, 16);
  EXPECT_EQ(graph.edges[5].to, 28);
  EXPECT_NEAR(graph.edges[5].T_from_to.translation.x(), 4.0, 1e-12);
  EXPECT_NEAR(graph.edges[5].information(0, 0), 0.25, 1e-9);
  EXPECT_NEAR(graph.edges[5].information(5, 5), 16.0, 1e-9);
}

}  // namespace
}  // namespace lidar_mapping::back_end
