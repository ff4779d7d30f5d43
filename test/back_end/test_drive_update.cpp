// SPDX-License-Identifier: BSD-3-Clause
// What a drive takes over from a solution, while it has gone on.

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "drive/drive_update.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

/// A straight drive of one segment, with a key frame at each metre and loops back to the first one.
DriveGraph straight(int nodes, int loops) {
  DriveGraph drive;
  for (int i = 0; i < nodes; ++i) {
    DriveNode node;
    node.index = static_cast<KeyFrameIndex>(i);
    node.connected = i > 0;
    node.stamp = from_seconds(i);
    node.T_odom_base.translation.x() = i;
    node.T_map_base = node.T_odom_base;
    drive.nodes.push_back(node);
  }
  for (int i = 0; i < loops; ++i) {
    DriveLoop loop;
    loop.to = i + 1;
    drive.loops.push_back(loop);
  }
  drive.in_enu = {false};
  drive.gnss_delays.resize(1);
  return drive;
}

void add_gnss(DriveGraph& drive, int node) {
  DriveGnss gnss;
  gnss.node = node;
  drive.gnss.push_back(gnss);
}

void use(DriveGnss& gnss) { gnss.horizontal_used = gnss.altitude_used = gnss.evaluated = true; }
void use(DriveLoop& loop) { loop.used = loop.evaluated = true; }

/// y of the poses in the map.
std::vector<double> sideways(const DriveGraph& drive) {
  std::vector<double> result;
  for (const DriveNode& node : drive.nodes) result.push_back(node.T_map_base.translation.y());
  return result;
}

TEST(ApplyWholeSolution, NewKeyFramesFollowByOdometry) {
  DriveGraph drive = straight(5, 0);
  DriveGraph solved = straight(3, 0);
  solved.nodes[1].T_map_base.translation.y() = 7.0;
  solved.nodes[2].T_map_base = {exp_so3({0.0, 0.0, kPi / 2.0}), {2.0, 5.0, 0.0}};
  apply_whole_solution(solved, drive);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(test::near(drive.nodes[i].T_map_base, solved.nodes[i].T_map_base, 1e-12)) << i;
  }
  const Eigen::Quaterniond left = exp_so3({0.0, 0.0, kPi / 2.0});
  EXPECT_TRUE(test::near(drive.nodes[3].T_map_base, Pose{left, {2.0, 6.0, 0.0}}, 1e-9));
  EXPECT_TRUE(test::near(drive.nodes[4].T_map_base, Pose{left, {2.0, 7.0, 0.0}}, 1e-9));
}

TEST(ApplyWholeSolution, AppliesTheEstimatesToTheSegmentsThatWereSolved) {
  DriveGraph drive = straight(3, 0);
  drive.in_enu = {false, false};
  drive.gnss_delays.resize(2);
  DriveGraph solved = straight(2, 0);
  solved.in_enu = {true};
  solved.gnss_delays[0].seconds = 0.08;
  solved.odometry_errors.scale_error = 0.02;
  solved.T_map_first.translation.z() = 4.0;
  apply_whole_solution(solved, drive);
  EXPECT_EQ(drive.in_enu, (std::vector<bool>{true, false}));
  EXPECT_EQ(drive.gnss_delays[0].seconds, 0.08);
  EXPECT_EQ(drive.gnss_delays[1].seconds, 0.0);
  EXPECT_EQ(drive.odometry_errors.scale_error, 0.02);
  EXPECT_EQ(drive.T_map_first.translation.z(), 4.0);
}

TEST(ApplyWholeSolution, DecidesOnlyOnTheConstraintsThatWereSolved) {
  DriveGraph solved = straight(4, 1);
  add_gnss(solved, 2);
  use(solved.loops[0]);
  use(solved.gnss[0]);
  // Since then came another loop, and positions at key frames before and after.
  DriveGraph drive = straight(5, 2);
  for (const int node : {1, 2, 4}) add_gnss(drive, node);
  apply_whole_solution(solved, drive);
  EXPECT_TRUE(drive.loops[0].used);
  EXPECT_TRUE(drive.loops[0].evaluated);
  EXPECT_FALSE(drive.loops[1].used);
  EXPECT_FALSE(drive.loops[1].evaluated);
  const bool expected[] = {false, true, false};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drive.gnss[i].horizontal_used, expected[i]) << i;
    EXPECT_EQ(drive.gnss[i].altitude_used, expected[i]) << i;
    EXPECT_EQ(drive.gnss[i].evaluated, expected[i]) << i;
  }
}

/// A drive of eight key frames, of which the window holds three and one of the three loops.
class ApplyWindowSolution : public testing::Test {
 protected:
  ApplyWindowSolution() : drive_(straight(8, 3)) {
    for (const int node : {1, 3, 5}) add_gnss(drive_, node);
    window_.nodes = {2, 3, 5};
    window_.fixed = {true, false, false};
    window_.loops = {1};
    solved_ = extract_window(drive_, window_);
    for (std::size_t i = 0; i < 3; ++i) {
      solved_.nodes[i].T_map_base.translation.y() = 0.1 * static_cast<double>(i + 1);
    }
  }

  DriveGraph drive_;
  DriveWindow window_;
  DriveGraph solved_;
};

TEST_F(ApplyWindowSolution, MovesItsKeyFramesAndThoseThatCameSince) {
  apply_window_solution(solved_, window_, 6, drive_);
  const std::vector<double> expected = {0.0, 0.0, 0.1, 0.2, 0.0, 0.3, 0.3, 0.3};
  const std::vector<double> actual = sideways(drive_);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(actual[i], expected[i], 1e-12) << i;
  }
}

TEST_F(ApplyWindowSolution, LeavesKeyFramesBehindItThatTheSolutionKnew) {
  apply_window_solution(solved_, window_, 8, drive_);
  EXPECT_EQ(sideways(drive_)[6], 0.0);
  EXPECT_EQ(sideways(drive_)[7], 0.0);
}

TEST_F(ApplyWindowSolution, DecidesAboutItsLoopsAndPositionsAlone) {
  ASSERT_EQ(solved_.loops.size(), 1U);
  ASSERT_EQ(solved_.gnss.size(), 2U);
  EXPECT_EQ(solved_.gnss[1].node, 2) << "its number in the window";
  use(solved_.loops[0]);
  use(solved_.gnss[1]);
  solved_.gnss[0].evaluated = true;
  apply_window_solution(solved_, window_, 8, drive_);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drive_.loops[i].used, i == 1) << i;
    EXPECT_EQ(drive_.loops[i].evaluated, i == 1) << i;
    EXPECT_EQ(drive_.gnss[i].horizontal_used, i == 2) << i;
    EXPECT_EQ(drive_.gnss[i].evaluated, i >= 1) << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::back_end
