// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

class TrajectoryFile : public testing::Test {
 protected:
  Trajectory read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_trajectory(path_);
  }
  /// What is wrong with a file; empty if nothing is.
  std::string problem(const std::string& text) {
    return test::error_text<InputError>([&] { read(text); });
  }
  const test::TemporaryFolder folder_;
  const std::string path_ = (folder_.path() / "trajectory.txt").string();
};

Trajectory sample() {
  Trajectory trajectory;
  trajectory.poses.push_back({1317384506123456789, {exp_so3({0.1, -0.2, 3.0}), {1e4, -2e4, 3.0}}});
  trajectory.poses.push_back({1317384506223456788, {exp_so3({0.3, 0.2, -1.0}), {1e4, -2e4, 4.0}}});
  return trajectory;
}

// Stamps to the nanosecond, positions to less than a micrometre.
TEST_F(TrajectoryFile, TumComesBackTheSame) {
  const Trajectory again = read(to_tum(sample()));
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_TRUE(again.has_stamps);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.poses[i].stamp, sample().poses[i].stamp);
    EXPECT_TRUE(test::near(again.poses[i].pose, sample().poses[i].pose, 1e-8));
  }
}

// A stamp below zero has its sign once, and not in its fraction, too.
TEST_F(TrajectoryFile, TumHasStampsBeforeTheEpochToo) {
  const Trajectory before{{{-1'500'000'000, Pose()}, {-250'000'000, Pose()}}, true};
  EXPECT_EQ(to_tum(before).substr(0, 13), "-1.500000000 ");
  const Trajectory again = read(to_tum(before));
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_EQ(again.poses[0].stamp, -1'500'000'000);
  EXPECT_EQ(again.poses[1].stamp, -250'000'000);
}

TEST_F(TrajectoryFile, KittiComesBackTheSame) {
  const Trajectory again = read(to_kitti(sample()));
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_FALSE(again.has_stamps);
  EXPECT_TRUE(test::near(again.poses[1].pose, sample().poses[1].pose, 1e-6));
}

TEST_F(TrajectoryFile, SkipsComments) {
  EXPECT_EQ(read("# stamp x y z\n1.5 0 0 0 0 0 0 1\n").poses.at(0).stamp, 1500000000);
}

// Of two files that were put together the later one may stand first.
TEST_F(TrajectoryFile, IsReadInTheOrderOfItsStamps) {
  const Trajectory trajectory = read(
      "20 5 0 0 0 0 0 1\n21 6 0 0 0 0 0 1\n22 7 0 0 0 0 0 1\n"
      "10 1 0 0 0 0 0 1\n11 2 0 0 0 0 0 1\n12 3 0 0 0 0 0 1\n");
  ASSERT_EQ(trajectory.poses.size(), 6U);
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_LT(trajectory.poses[i - 1].stamp, trajectory.poses[i].stamp) << i;
  }
  for (const double seconds : {10.5, 11.5, 20.5, 21.5}) {
    const auto pose = pose_at(from_seconds(seconds), trajectory, 1.5);
    ASSERT_TRUE(pose) << seconds;
    EXPECT_NEAR(pose->translation.x(), seconds < 15.0 ? seconds - 9.0 : seconds - 15.0, 1e-9);
  }
}

TEST_F(TrajectoryFile, NamesTheMalformedLine) {
  EXPECT_NE(problem("1.0 0 0 0 0 0 0 1\n2.0 0 0\n").find(":2: expected 8 numbers"),
            std::string::npos);
}

TEST(Trajectory, SaysWhichFileIsMissing) {
  EXPECT_THROW(read_trajectory("/nonexistent.tum"), FileError);
}

// Of what no vehicle can have been at: nan, inf, beyond the Moon, no rotation.
TEST_F(TrajectoryFile, RefusesNonsenseWithFileAndLine) {
  const std::string good_tum = "100.5 1 2 3 0 0 0 1\n";
  const std::string good_kitti = "1 0 0 5 0 1 0 6 0 0 1 7\n";
  const std::string bad[] = {good_tum + "101 nan 2 3 0 0 0 1\n",
                             good_tum + "101 1 inf 3 0 0 0 1\n",
                             good_tum + "nan 1 2 3 0 0 0 1\n",
                             good_tum + "1e30 1 2 3 0 0 0 1\n",
                             good_tum + "101 1e200 2 3 0 0 0 1\n",
                             good_tum + "101 1 2 3x 0 0 0 1\n",
                             good_tum + "101 1 2 3 0 0 0 0\n",
                             good_tum + "101 1 2 3 0 0 nan 1\n",
                             good_tum + "1.2.3 1 2 3 0 0 0 1\n",
                             good_tum + "99999999999999999999 1 2 3 0 0 0 1\n",
                             good_tum + good_kitti,
                             good_kitti + "1 0 0 nan 0 1 0 6 0 0 1 7\n",
                             good_kitti + "1 0 0 5 0 1 0 6 0 0 7 7\n",
                             good_kitti + "1 0 0 5 0 1 0 6 0 0 -1 7\n"};
  for (const std::string& text : bad) {
    EXPECT_EQ(problem(text).rfind(path_ + ":2: ", 0), 0U) << text << problem(text);
  }
}

TEST(TrajectoryTest, SortsByStampAndKeepsTheOrderOfEqualOnes) {
  Trajectory trajectory;
  for (const auto& [stamp, x] : {std::pair(30, 1.0), std::pair(10, 2.0), std::pair(30, 3.0),
                                 std::pair(20, 4.0), std::pair(10, 5.0)}) {
    trajectory.poses.push_back({stamp, {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}});
  }
  sort_by_stamp(trajectory);
  std::vector<double> order;
  for (const StampedPose& pose : trajectory.poses) order.push_back(pose.pose.translation.x());
  EXPECT_EQ(order, (std::vector<double>{2.0, 5.0, 4.0, 1.0, 3.0}));
}

TEST(PoseAt, InterpolatesWithinShortGapsOnly) {
  Trajectory trajectory;
  trajectory.poses.push_back({from_seconds(1.0), Pose{}});
  trajectory.poses.push_back({from_seconds(1.4), {exp_so3({0.0, 0.0, 0.4}), {4.0, 0.0, 0.0}}});
  trajectory.poses.push_back({from_seconds(2.4), {exp_so3({0.0, 0.0, 0.4}), {9.0, 0.0, 0.0}}});
  const auto between = pose_at(from_seconds(1.1), trajectory, 0.5);
  ASSERT_TRUE(between);
  EXPECT_TRUE(test::near(*between, Pose{exp_so3({0.0, 0.0, 0.1}), {1.0, 0.0, 0.0}}, 1e-9));
  EXPECT_TRUE(pose_at(from_seconds(2.4), trajectory, 0.5)) << "at a pose no gap matters";
  EXPECT_FALSE(pose_at(from_seconds(2.0), trajectory, 0.5));
  EXPECT_TRUE(pose_at(from_seconds(2.0), trajectory, 1.5));
  EXPECT_FALSE(pose_at(from_seconds(0.9), trajectory, 0.5));
  EXPECT_FALSE(pose_at(from_seconds(2.5), trajectory, 0.5));
  EXPECT_FALSE(pose_at(from_seconds(1.0), Trajectory{}, 0.5));
}

}  // namespace
}  // namespace lidar_mapping
