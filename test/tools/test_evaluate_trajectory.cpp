// evaluate_trajectory's figures against a computation that shares no code with it (numpy).
#include <cstdlib>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/trajectory.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;

Pose slip(std::mt19937& random, double sigma_m, double sigma_rad) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d turn =
      sigma_rad * Eigen::Vector3d(normal(random), normal(random), normal(random));
  Pose pose;
  pose.translation = sigma_m * Eigen::Vector3d(normal(random), normal(random), normal(random));
  pose.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return pose;
}

/// A winding way of 500 m over a hill, and an estimate that drifts and lies elsewhere.
struct Drive {
  Trajectory truth;
  Trajectory estimate;

  Drive() {
    std::mt19937 random(5);
    const Pose elsewhere = slip(random, 3.0, 0.5);
    Pose drift;
    for (int i = 0; i < 500; ++i) {
      const double way = i;
      Pose pose;
      pose.translation = {way, 30.0 * std::sin(way / 40.0), 5.0 * std::sin(way / 90.0)};
      pose.rotation = Eigen::AngleAxisd(0.7 * std::cos(way / 40.0), Eigen::Vector3d::UnitZ()) *
                      Eigen::AngleAxisd(0.05 * std::cos(way / 90.0), Eigen::Vector3d::UnitY());
      drift = drift * slip(random, 0.01, 0.001);
      const Stamp stamp = from_seconds(100.0) + Stamp{i} * from_seconds(0.1);
      truth.poses.push_back({stamp, pose});
      estimate.poses.push_back({stamp, elsewhere * pose * drift});
    }
  }
};

class EvaluateTrajectory : public testing::TestWithParam<std::string> {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }

  /// Runs the program on the files "truth" and "estimate", and the check on what it says.
  void expect_right() const {
    const std::string files = "'" + (folder_.path() / "truth").string() + "' '" +
                              (folder_.path() / "estimate").string() + "' ";
    const std::string figures = "'" + (folder_.path() / "figures.json").string() + "'";
    const std::string command = std::string(LIDAR_MAPPING_EVALUATE_TRAJECTORY) + " " + files +
                                "--json " + figures + " " + GetParam() + " > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    EXPECT_EQ(std::system(("python3 tools/check_trajectory_errors.py " + files + figures).c_str()),
              0);
  }

  const test::TemporaryFolder folder_;
  const Drive drive_;
};

TEST_P(EvaluateTrajectory, IsRightForKittiFiles) {
  write("truth", to_kitti(drive_.truth));
  write("estimate", to_kitti(drive_.estimate));
  expect_right();
}

TEST_P(EvaluateTrajectory, IsRightForTumFiles) {
  write("truth", to_tum(drive_.truth));
  write("estimate", to_tum(drive_.estimate));
  expect_right();
}

// The truth is interpolated, and what lies outside of it is left out.
TEST_P(EvaluateTrajectory, IsRightWhereStampsDiffer) {
  Trajectory shifted = drive_.estimate;
  for (StampedPose& pose : shifted.poses) pose.stamp += from_seconds(0.037);
  write("truth", to_tum(drive_.truth));
  write("estimate", to_tum(shifted));
  expect_right();
}

INSTANTIATE_TEST_SUITE_P(All, EvaluateTrajectory,
                         testing::Values("", "--align", "--delta 50 --align --lengths 100 300"));

}  // namespace
}  // namespace lidar_mapping::tools
