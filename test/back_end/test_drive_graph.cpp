// SPDX-License-Identifier: BSD-3-Clause
// What follows from the data of a drive alone, with numbers that are told by hand.

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "drive/drive_graph.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

/// Segments of two key frames each, which stand still.
DriveGraph segments(int count) {
  DriveGraph drive;
  for (int i = 0; i < 2 * count; ++i) {
    DriveNode node;
    node.index = static_cast<KeyFrameIndex>(i);
    node.segment = i / 2;
    node.connected = i % 2 == 1;
    node.stamp = from_seconds(i);
    drive.nodes.push_back(node);
  }
  drive.in_enu.assign(static_cast<std::size_t>(count), false);
  drive.gnss_delays.resize(static_cast<std::size_t>(count));
  return drive;
}

/// Adds a loop between key frames of two segments.
void connect(DriveGraph& drive, int from, int to, bool used, bool evaluated) {
  DriveLoop loop;
  loop.from = 2 * from;
  loop.to = 2 * to + 1;
  loop.used = used;
  loop.evaluated = evaluated;
  drive.loops.push_back(loop);
}

/// Of five segments, 1, 3 and 4 are connected by loops in use, one of these and the first one by a
/// loop that nobody has decided about, and the third one by a refused loop.
DriveGraph partly_connected() {
  DriveGraph drive = segments(5);
  connect(drive, 3, 4, true, true);
  connect(drive, 1, 3, true, true);
  connect(drive, 0, 4, false, false);
  connect(drive, 0, 2, false, true);
  return drive;
}

TEST(ConnectedSegments, HaveTheSmallestNumberAmongThem) {
  const DriveGraph drive = partly_connected();
  EXPECT_EQ(connected_segments(drive, false), (std::vector<int>{0, 1, 2, 1, 1}));
  EXPECT_EQ(connected_segments(drive, true), (std::vector<int>{0, 0, 2, 0, 0}));
}

TEST(SegmentsInEnu, AreThoseThatWereAlignedAndAllThatLoopsConnect) {
  DriveGraph drive = partly_connected();
  EXPECT_EQ(segments_in_enu(drive), std::vector<bool>(5, false));
  drive.in_enu[4] = true;
  EXPECT_EQ(segments_in_enu(drive), (std::vector<bool>{true, true, false, true, true}));
  drive.in_enu = {false, false, true, false, false};
  EXPECT_EQ(segments_in_enu(drive), drive.in_enu) << "a refused loop connects nothing";
}

TEST(DriveGraphPoses, TheNewestKeyFrameGivesTheCorrection) {
  EXPECT_TRUE(test::near(DriveGraph().T_map_odom(), Pose::Identity(), 1e-12));
  DriveGraph drive = segments(1);
  drive.nodes[0].T_map_base.translation.x() = 100.0;
  drive.nodes[1].T_odom_base = {exp_so3({0.0, 0.0, 0.5}), {3.0, 4.0, 0.0}};
  drive.nodes[1].T_map_base = {exp_so3({0.0, 0.0, 0.8}), {7.0, -2.0, 1.0}};
  EXPECT_TRUE(test::near(drive.T_map_odom() * drive.nodes[1].T_odom_base, drive.nodes[1].T_map_base,
                         1e-12));
}

/// A motion of 2 m, with drift of 0.5 m and 5 degrees.
class Motion : public testing::Test {
 protected:
  Motion() : drive_(segments(1)) {
    const Eigen::Quaterniond left = exp_so3({0.0, 0.0, kPi / 2.0});
    drive_.nodes[0].T_odom_base = {left, {10.0, 0.0, 0.0}};
    drive_.nodes[1].T_odom_base = {left, {10.0, 2.0, 0.0}};
    config_.odometry_min_stddev_m = 0.3;
    config_.odometry_drift = 0.2;
    config_.odometry_min_stddev_rad = 3.0 * kRadPerDeg;
    config_.odometry_rotation_drift = 2.0 * kRadPerDeg;
    config_.floor_stddev_rad = 0.0;
  }
  void add_floor(int node, double sigma_x, double sigma_y) {
    Floor floor;
    floor.covariance = Eigen::Vector3d(sigma_x * sigma_x, sigma_y * sigma_y, 1.0).asDiagonal();
    drive_.floors.push_back({floor, node});
  }
  /// The variance that drift adds, along and about the axes.
  Vector6d drift_variance() const {
    return (motion_covariance_to(drive_, 1, config_) - drive_.nodes[1].step_covariance).diagonal();
  }

  DriveGraph drive_;
  BackEndConfig config_;
};

constexpr double kDriftAngle = 5.0 * kRadPerDeg;

Vector6d squares(double x, double y, double z, double roll, double pitch, double yaw) {
  return (Vector6d() << x, y, z, roll, pitch, yaw).finished().cwiseAbs2();
}

TEST_F(Motion, IsThatOfOdometryWithItsScale) {
  EXPECT_TRUE(test::near(motion_to(drive_, 1).translation, Eigen::Vector3d(2.0, 0.0, 0.0), 1e-12));
  drive_.odometry_errors.scale_error = 0.01;
  EXPECT_TRUE(test::near(motion_to(drive_, 1).translation, Eigen::Vector3d(2.02, 0.0, 0.0), 1e-12));
  EXPECT_NEAR(rotation_angle(motion_to(drive_, 1).rotation), 0.0, 1e-12);
}

TEST_F(Motion, HasTheFractionOfTheDriftThatPositionsShow) {
  const double a = kDriftAngle;
  EXPECT_TRUE(test::near(drift_variance(), squares(0.5, 0.5, 0.5, a, a, a), 1e-12));
  drive_.odometry_errors.drift_fraction << 0.5, 1.0, 0.1, 1.0, 0.4, 0.2;
  EXPECT_TRUE(test::near(drift_variance(), squares(0.25, 0.5, 0.05, a, 0.4 * a, 0.2 * a), 1e-12));
}

// Floors of 0.06 and 0.08 rad differ by 0.1 rad, which is a little more than the drift.
TEST_F(Motion, BetweenFloorsDriftsLessInHeightRollAndPitch) {
  config_.floor_constraint = FloorConstraint::kNeighbours;
  add_floor(0, 0.06, 0.01);
  const double a = kDriftAngle;
  const Vector6d whole = squares(0.5, 0.5, 0.5, a, a, a);
  EXPECT_TRUE(test::near(drift_variance(), whole, 1e-12)) << "of one alone";
  add_floor(1, 0.08, 0.01);
  const double f = a / 0.1;
  ASSERT_LT(f, 1.0);
  EXPECT_TRUE(test::near(drift_variance(), squares(0.5, 0.5, 0.5 * f, a * f, a * f, a), 1e-12));
  drive_.odometry_errors.drift_fraction.setConstant(0.5);
  EXPECT_TRUE(test::near(drift_variance(), 0.25 * whole, 1e-12)) << "positions show less already";
}

TEST_F(Motion, KeepsItsDriftBetweenFloorsThatDifferLess) {
  config_.floor_constraint = FloorConstraint::kNeighbours;
  add_floor(0, 0.006, 0.01);
  add_floor(1, 0.008, 0.01);
  const double a = kDriftAngle;
  EXPECT_TRUE(test::near(drift_variance(), squares(0.5, 0.5, 0.5, a, a, a), 1e-12))
      << "the floors differ by less than the drift";
  drive_.floors[0].floor.covariance(1, 1) = 0.04;
  config_.floor_constraint = FloorConstraint::kPlane;
  EXPECT_TRUE(test::near(drift_variance(), squares(0.5, 0.5, 0.5, a, a, a), 1e-12))
      << "one plane for all joins no neighbours";
}

TEST(CountUsage, CountsWhatIsUsedAndWhatIsNot) {
  DriveGraph drive = partly_connected();
  drive.unusable_gnss = 3;
  for (const bool is_used : {true, false, true}) {
    DriveGnss gnss;
    gnss.horizontal_used = is_used;
    gnss.altitude_used = !is_used;
    drive.gnss.push_back(gnss);
  }
  const UsageCounts counts = count_usage(drive);
  EXPECT_EQ(counts.loops_used, 2U);
  EXPECT_EQ(counts.loops_refused, 2U);
  EXPECT_EQ(counts.gnss_used, 2U);
  EXPECT_EQ(counts.gnss_refused, 4U);
}

/// Gives a node a tilt about x in the map, while its IMU says that it is level.
void tilt(DriveGraph& drive, int node, double angle) {
  drive.nodes[node].T_map_base.rotation = exp_so3({angle, 0.0, 0.0});
  DriveImu imu;
  imu.sample.orientation = Eigen::Quaterniond::Identity();
  imu.node = node;
  drive.imu.push_back(imu);
}

TEST(GravityAlignment, MakesTheSelectedSegmentsLevel) {
  DriveGraph drive = segments(2);
  tilt(drive, 1, 0.2);
  tilt(drive, 2, 0.5);
  const BackEndConfig config;
  const auto turn = [&](bool first, bool second) {
    return log_so3(gravity_alignment(drive, {first, second}, config));
  };
  EXPECT_TRUE(test::near(turn(true, false), Eigen::Vector3d(-0.2, 0.0, 0.0), 1e-9));
  EXPECT_TRUE(test::near(turn(false, true), Eigen::Vector3d(-0.5, 0.0, 0.0), 1e-9));
  EXPECT_TRUE(test::near(turn(true, true), Eigen::Vector3d(-0.35, 0.0, 0.0), 1e-9)) << "the mean";
  EXPECT_TRUE(test::near(turn(false, false), Eigen::Vector3d(0.0, 0.0, 0.0), 1e-12));
}

}  // namespace
}  // namespace lidar_mapping::back_end
