#include <cstdio>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"

namespace lidar_mapping {
namespace {

class TrajectoryFile : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  Trajectory read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_trajectory(path_);
  }
  const std::string path_ = (std::filesystem::temp_directory_path() /
                             ("trajectory_" + std::to_string(::getpid()) + ".txt"))
                                .string();
};

Trajectory sample() {
  Trajectory trajectory;
  trajectory.poses.push_back({1317384506123456789, {exp_so3({0.1, -0.2, 3.0}), {1e4, -2e4, 3.0}}});
  trajectory.poses.push_back({1317384506223456788, {exp_so3({0.3, 0.2, -1.0}), {1e4, -2e4, 4.0}}});
  return trajectory;
}

// F58: stamps to the nanosecond, positions to less than a micrometre.
TEST_F(TrajectoryFile, TumComesBackTheSame) {
  const Trajectory again = read(to_tum(sample()));
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_TRUE(again.has_stamps);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.poses[i].stamp, sample().poses[i].stamp);
    EXPECT_LT(difference(again.poses[i].pose, sample().poses[i].pose).norm(), 1e-8);
  }
}

TEST_F(TrajectoryFile, KittiComesBackTheSame) {
  const Trajectory again = read(to_kitti(sample()));
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_FALSE(again.has_stamps);
  EXPECT_LT(difference(again.poses[1].pose, sample().poses[1].pose).norm(), 1e-6);
}

TEST_F(TrajectoryFile, SkipsComments) {
  EXPECT_EQ(read("# stamp x y z\n1.5 0 0 0 0 0 0 1\n").poses.at(0).stamp, 1500000000);
}

TEST_F(TrajectoryFile, NamesTheMalformedLine) {
  try {
    read("1.0 0 0 0 0 0 0 1\n2.0 0 0\n");
    FAIL() << "a line of three numbers was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(":2: expected 8 numbers"), std::string::npos);
  }
}

TEST(Trajectory, SaysWhichFileIsMissing) {
  EXPECT_THROW(read_trajectory("/nonexistent.tum"), FileError);
}

}  // namespace
}  // namespace lidar_mapping
