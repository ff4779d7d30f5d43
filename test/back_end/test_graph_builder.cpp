// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "drive/graph_builder.hpp"
#include "error_text.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Stamp stamp_of(KeyFrameIndex index) { return from_seconds(100.0 + 0.5 * index); }

KeyFrame key_frame(KeyFrameIndex index, double x, std::uint32_t segment = 0) {
  KeyFrame result;
  result.index = index;
  result.segment = segment;
  result.stamp = stamp_of(index);
  result.T_odom_base.translation.x() = x;
  result.motion_covariance = diagonal_covariance(0.01, 0.001);
  return result;
}

GnssPosition position_at(KeyFrameIndex index, double x = 0.0, double sigma = 1.0) {
  GnssPosition position;
  position.stamp = stamp_of(index);
  position.p_enu_antenna = {x, 0.0, 0.0};
  position.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return position;
}

Floor floor_at(KeyFrameIndex index) {
  Floor floor;
  floor.stamp = stamp_of(index);
  floor.found = true;
  return floor;
}

ImuSample imu_at(KeyFrameIndex index) {
  ImuSample sample;
  sample.stamp = stamp_of(index);
  return sample;
}

Loop loop_between(KeyFrameIndex from, KeyFrameIndex to) {
  Loop loop;
  loop.from = from;
  loop.to = to;
  loop.covariance = diagonal_covariance(0.02, 0.002);
  return loop;
}

/// A drive of key frames 10, 20, ... at every metre.
class GraphBuilderTest : public testing::Test {
 protected:
  void drive_to(KeyFrameIndex last) {
    for (KeyFrameIndex index = 10; index <= last; index += 10) {
      builder_.add_key_frame(key_frame(index, 0.1 * index), drive_);
    }
  }
  std::string error_of(const KeyFrame& bad) {
    return test::error_text<InputError>([&] { builder_.add_key_frame(bad, drive_); });
  }

  BackEndConfig config_;
  GraphBuilder builder_{config_};
  DriveGraph drive_;
};

TEST_F(GraphBuilderTest, AttachesMeasurementsInEitherOrderOfArrival) {
  builder_.add_gnss(position_at(10), drive_);
  builder_.add_imu(imu_at(10), drive_);
  builder_.add_floor(floor_at(10), drive_);
  EXPECT_TRUE(drive_.gnss.empty()) << "their key frame is not there yet";
  drive_to(20);
  builder_.add_gnss(position_at(20), drive_);
  builder_.add_imu(imu_at(20), drive_);
  builder_.add_floor(floor_at(20), drive_);
  ASSERT_EQ(drive_.gnss.size(), 2U);
  ASSERT_EQ(drive_.imu.size(), 2U);
  ASSERT_EQ(drive_.floors.size(), 2U);
  for (std::size_t node = 0; node < 2; ++node) {
    EXPECT_EQ(drive_.gnss[node].node, static_cast<int>(node));
    EXPECT_EQ(drive_.imu[node].node, static_cast<int>(node));
    EXPECT_EQ(drive_.floors[node].node, static_cast<int>(node));
    EXPECT_EQ(drive_.gnss[node].position.stamp, drive_.nodes[node].stamp);
  }
}

TEST_F(GraphBuilderTest, KeepsMeasurementsInTheOrderOfTheirKeyFrames) {
  drive_to(50);
  for (const KeyFrameIndex index : {30U, 10U, 50U, 20U, 40U}) {
    builder_.add_gnss(position_at(index), drive_);
    builder_.add_floor(floor_at(index), drive_);
  }
  ASSERT_EQ(drive_.gnss.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(drive_.gnss[i].node, static_cast<int>(i));
    EXPECT_EQ(drive_.floors[i].node, static_cast<int>(i));
  }
}

TEST_F(GraphBuilderTest, TakesTheFirstOfTwoMeasurementsAtAKeyFrame) {
  drive_to(20);
  builder_.add_gnss(position_at(20, 1.0), drive_);
  builder_.add_gnss(position_at(20, 2.0), drive_);
  ASSERT_EQ(drive_.gnss.size(), 1U);
  EXPECT_EQ(drive_.gnss[0].position.p_enu_antenna.x(), 1.0);
  EXPECT_EQ(builder_.new_data().gnss, 1);
}

TEST_F(GraphBuilderTest, LeavesMeasurementsWithoutAKeyFrame) {
  drive_to(20);
  builder_.add_gnss(position_at(15), drive_);
  builder_.add_imu(imu_at(15), drive_);
  builder_.add_key_frame(key_frame(30, 3.0), drive_);
  EXPECT_TRUE(drive_.gnss.empty());
  EXPECT_TRUE(drive_.imu.empty());
  EXPECT_EQ(drive_.unusable_gnss, 0U);
}

// A front end that stands still for long while GNSS goes on: the memory is bounded.
TEST(PendingMeasurements, DiscardsTheOldestOfMoreThanAThousand) {
  PendingMeasurements<int> pending;
  for (int i = 1001; i > 0; --i) pending.add(i, 10 * i);
  EXPECT_FALSE(pending.extract(1).has_value());
  EXPECT_EQ(pending.extract(2), 20);
  EXPECT_FALSE(pending.extract(2).has_value()) << "given once";
  EXPECT_EQ(pending.extract(1001), 10'010);
}

TEST_F(GraphBuilderTest, CountsPositionsThatAreOfNoUse) {
  drive_to(10);
  GnssPosition position = position_at(10);
  position.p_enu_antenna.x() = kNaN;
  builder_.add_gnss(position, drive_);
  position = position_at(10);
  position.p_base_antenna.z() = kNaN;
  builder_.add_gnss(position, drive_);
  position = position_at(10);
  position.covariance(0, 0) = 0.0;
  builder_.add_gnss(position, drive_);
  position.covariance(0, 0) = kNaN;
  builder_.add_gnss(position, drive_);
  position = position_at(10);
  position.covariance(0, 1) = position.covariance(1, 0) = 2.0;
  builder_.add_gnss(position, drive_);
  builder_.add_gnss(position_at(10, 0.0, 1.1 * config_.gnss_max_stddev_m), drive_);
  EXPECT_TRUE(drive_.gnss.empty());
  EXPECT_EQ(drive_.unusable_gnss, 6U);
  EXPECT_EQ(builder_.new_data().gnss, 0);
  position = position_at(10);
  position.p_enu_antenna.z() = kNaN;  // a receiver without altitude
  builder_.add_gnss(position, drive_);
  EXPECT_EQ(drive_.gnss.size(), 1U);
}

// A receiver gives a position to each scan, of which few are key frames.
TEST_F(GraphBuilderTest, CountsUselessPositionsOfKeyFramesAlone) {
  const double useless = 1.1 * config_.gnss_max_stddev_m;
  builder_.add_gnss(position_at(10, 0.0, useless), drive_);
  for (KeyFrameIndex index = 11; index < 20; ++index) {
    builder_.add_gnss(position_at(index, 0.0, useless), drive_);
  }
  EXPECT_EQ(drive_.unusable_gnss, 0U) << "their key frames are not there yet";
  drive_to(20);
  builder_.add_gnss(position_at(15, 0.0, useless), drive_);
  builder_.add_gnss(position_at(20, 0.0, useless), drive_);
  EXPECT_TRUE(drive_.gnss.empty());
  EXPECT_EQ(drive_.unusable_gnss, 2U);
}

TEST_F(GraphBuilderTest, LeavesOutMeasurementsThatAreNone) {
  drive_to(10);
  Floor floor = floor_at(10);
  floor.found = false;
  builder_.add_floor(floor, drive_);
  floor = floor_at(10);
  floor.offset = kNaN;
  builder_.add_floor(floor, drive_);
  floor = floor_at(10);
  floor.normal.x() = kNaN;
  builder_.add_floor(floor, drive_);
  floor = floor_at(10);
  floor.covariance(2, 2) = std::numeric_limits<double>::infinity();
  builder_.add_floor(floor, drive_);
  EXPECT_TRUE(drive_.floors.empty());
  ImuSample sample = imu_at(10);
  sample.linear_acceleration.y() = kNaN;
  builder_.add_imu(sample, drive_);
  sample = imu_at(10);
  sample.orientation = Eigen::Quaterniond(kNaN, 0.0, 0.0, 0.0);
  builder_.add_imu(sample, drive_);
  EXPECT_TRUE(drive_.imu.empty());
}

TEST_F(GraphBuilderTest, RefusesKeyFramesThatCannotBe) {
  drive_to(20);
  const std::string repeated = error_of(key_frame(20, 3.0));
  EXPECT_NE(repeated.find("key frame 20 follows key frame 20"), std::string::npos) << repeated;
  EXPECT_NE(error_of(key_frame(15, 3.0)), "");
  KeyFrame bad = key_frame(30, 3.0);
  bad.T_odom_base.rotation.x() = kNaN;
  const std::string text = error_of(bad);
  EXPECT_NE(text.find("key frame 30"), std::string::npos) << text;
  EXPECT_EQ(drive_.nodes.size(), 2U) << "the drive stays as it was";
  EXPECT_EQ(builder_.new_data().key_frames, 2);
  EXPECT_EQ(error_of(key_frame(30, 3.0)), "");
}

// Until the graph is solved again, a new key frame lies where odometry puts it behind the last one.
TEST_F(GraphBuilderTest, ContinuesFromTheNewestPoseInTheMap) {
  drive_to(20);
  EXPECT_TRUE(test::near(drive_.nodes[1].T_map_base, drive_.nodes[1].T_odom_base, 1e-12));
  const Pose corrected{exp_so3({0.0, 0.0, M_PI / 2.0}), {50.0, 60.0, 1.0}};
  drive_.nodes.back().T_map_base = corrected;
  builder_.add_key_frame(key_frame(30, 3.0), drive_);
  EXPECT_TRUE(
      test::near(drive_.nodes.back().T_map_base, Pose{corrected.rotation, {50.0, 61.0, 1.0}}, 1e-9))
      << "1 m ahead, which is now along y";
  EXPECT_TRUE(test::near(drive_.T_map_first, drive_.nodes.front().T_odom_base, 1e-12));
}

TEST_F(GraphBuilderTest, BeginsASegmentWhereOdometryDoes) {
  builder_.add_key_frame(key_frame(10, 0.0, 4), drive_);
  builder_.add_key_frame(key_frame(20, 1.0, 4), drive_);
  KeyFrame other = key_frame(30, 500.0, 7);
  other.doubtful = true;
  builder_.add_key_frame(other, drive_);
  other = key_frame(40, 501.0, 7);
  other.doubtful = true;
  builder_.add_key_frame(other, drive_);
  std::vector<int> segments;
  std::vector<bool> connected, doubtful;
  for (const DriveNode& node : drive_.nodes) {
    segments.push_back(node.segment);
    connected.push_back(node.connected);
    doubtful.push_back(node.doubtful);
  }
  EXPECT_EQ(segments, (std::vector<int>{0, 0, 1, 1})) << "whatever numbers the front end gives";
  EXPECT_EQ(connected, (std::vector<bool>{false, true, false, true}));
  EXPECT_EQ(doubtful, (std::vector<bool>{false, false, false, true}))
      << "of a step, if there is one";
  EXPECT_EQ(drive_.segment_starts, (std::vector<int>{0, 2}));
  EXPECT_EQ(drive_.in_enu.size(), 2U);
  EXPECT_EQ(drive_.gnss_delays.size(), 2U);
}

TEST_F(GraphBuilderTest, FindsKeyFramesOfLoopsByTheirIndex) {
  drive_to(50);
  EXPECT_TRUE(builder_.add_loop(loop_between(10, 40), drive_));
  ASSERT_EQ(drive_.loops.size(), 1U);
  EXPECT_EQ(drive_.loops[0].from, 0);
  EXPECT_EQ(drive_.loops[0].to, 3);
  EXPECT_FALSE(drive_.loops[0].used);
  EXPECT_FALSE(drive_.loops[0].evaluated);
  Loop refused = loop_between(20, 50);
  refused.decision = LoopDecision::kRefuse;
  EXPECT_TRUE(builder_.add_loop(refused, drive_));
  EXPECT_TRUE(drive_.loops[1].evaluated) << "a person has decided";
  EXPECT_EQ(builder_.new_data().loops, 2);
}

TEST_F(GraphBuilderTest, RefusesLoopsThatCannotBe) {
  drive_to(50);
  EXPECT_FALSE(builder_.add_loop(loop_between(10, 60), drive_)) << "not there yet";
  EXPECT_FALSE(builder_.add_loop(loop_between(15, 40), drive_)) << "no key frame";
  EXPECT_FALSE(builder_.add_loop(loop_between(20, 20), drive_)) << "with itself";
  Loop loop = loop_between(10, 40);
  loop.T_from_to.translation.z() = kNaN;
  EXPECT_FALSE(builder_.add_loop(loop, drive_));
  loop = loop_between(10, 40);
  loop.covariance(3, 3) = -1.0;
  EXPECT_FALSE(builder_.add_loop(loop, drive_));
  EXPECT_TRUE(drive_.loops.empty());
  EXPECT_EQ(builder_.new_data().loops, 0);
}

}  // namespace
}  // namespace lidar_mapping::back_end
