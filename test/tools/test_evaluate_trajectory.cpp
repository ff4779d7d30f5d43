// SPDX-License-Identifier: BSD-3-Clause
// evaluate_trajectory's figures against a computation that shares no code with it (numpy).
#include <cstdlib>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/trajectory.hpp"

#include "file_content.hpp"
#include "holds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::holds;

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

/// What the program says of two trajectories.
class EvaluateTrajectoryCommand : public testing::Test {
 protected:
  void write(const std::string& truth, const std::string& estimate) const {
    std::ofstream(folder_.path() / "truth") << truth;
    std::ofstream(folder_.path() / "estimate") << estimate;
  }
  void write(const Trajectory& truth, const Trajectory& estimate) const {
    write(to_tum(truth), to_tum(estimate));
  }
  /// Its path for a shell.
  std::string file(const std::string& name) const {
    return " '" + (folder_.path() / name).string() + "'";
  }
  std::string output_of(const std::string& options) const {
    const std::string command = LIDAR_MAPPING_EVALUATE_TRAJECTORY + file("truth") +
                                file("estimate") + " " + options + " >" + file("said");
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return test::content_of(folder_.path() / "said");
  }
  /// The truth as another frame on the vehicle has it, in a world of its own.
  static Trajectory seen_from(const Pose& T_base_frame, const Pose& T_world,
                              Trajectory trajectory) {
    for (StampedPose& pose : trajectory.poses) pose.pose = T_world * pose.pose * T_base_frame;
    return trajectory;
  }

  const test::TemporaryFolder folder_;
  const Trajectory drive_ = Drive().truth;
  const Pose lever_arm_{Eigen::Quaterniond::Identity(), {1.2, -0.9, 0.0}};
  const Pose elsewhere_{exp_so3({0.0, 0.0, 2.0}), {400.0, -30.0, 5.0}};
};

class EvaluateTrajectory : public EvaluateTrajectoryCommand,
                           public testing::WithParamInterface<std::string> {
 protected:
  /// Runs the program, and the check on what it says.
  void expect_right() const {
    output_of("--json" + file("figures.json") + " " + GetParam());
    const std::string check = "python3 tools/check_trajectory_errors.py" + file("truth") +
                              file("estimate") + file("figures.json");
    EXPECT_EQ(std::system(check.c_str()), 0);
  }

  const Drive drift_;
};

TEST_P(EvaluateTrajectory, IsRightForKittiFiles) {
  write(to_kitti(drift_.truth), to_kitti(drift_.estimate));
  expect_right();
}

TEST_P(EvaluateTrajectory, IsRightForTumFiles) {
  write(drift_.truth, drift_.estimate);
  expect_right();
}

// The truth is interpolated, and what lies outside of it is left out.
TEST_P(EvaluateTrajectory, IsRightWhereStampsDiffer) {
  Trajectory shifted = drift_.estimate;
  for (StampedPose& pose : shifted.poses) pose.stamp += from_seconds(0.037);
  write(drift_.truth, shifted);
  expect_right();
}

INSTANTIATE_TEST_SUITE_P(All, EvaluateTrajectory,
                         testing::Values("", "--align", "--delta 50 --align --lengths 100 300",
                                         "--align-origin", "--correct-scale", "-a -s",
                                         "-a --lever-arm 1.2 -0.9 0.4 --lever-rotation 10 -5 90"));

TEST_F(EvaluateTrajectoryCommand, ProposesToAlign) {
  write(seen_from(Pose::Identity(), elsewhere_, drive_), drive_);
  const std::string said = output_of("");
  EXPECT_TRUE(holds(said, "with --align: the trajectories lie in different frames"));
  EXPECT_FALSE(holds(output_of("--align"), "hint"));
}

TEST_F(EvaluateTrajectoryCommand, ProposesALeverArm) {
  write(seen_from(lever_arm_, Pose::Identity(), drive_), drive_);
  EXPECT_TRUE(holds(output_of(""), "with --lever-arm 1.20 -0.90 "));
  write(seen_from(lever_arm_, elsewhere_, drive_), drive_);
  for (const char* options : {"", "--align"}) {
    const std::string said = output_of(options);
    EXPECT_TRUE(holds(said, "with --align --lever-arm 1.20 -0.90 "));
  }
  const std::string said = output_of("--align --lever-arm 1.2 -0.9 0");
  EXPECT_FALSE(holds(said, "hint"));
  EXPECT_TRUE(holds(said, "APE translation          rmse    0.0000"));
}

TEST_F(EvaluateTrajectoryCommand, ProposesTheAxesOfTheTruth) {
  const Pose turned{exp_so3({0.0, 0.0, M_PI / 2.0}), Eigen::Vector3d::Zero()};
  write(seen_from(turned, Pose::Identity(), drive_), drive_);
  EXPECT_TRUE(holds(output_of(""), "--lever-rotation 0.0 0.0 90.0"));
}

// An error that grows is no frame and no lever arm.
TEST_F(EvaluateTrajectoryCommand, ProposesNothingForDrift) {
  const Drive drive;
  Trajectory near = drive.estimate;
  const Pose back = drive.truth.poses[0].pose * near.poses[0].pose.inverse();
  for (StampedPose& pose : near.poses) pose.pose = back * pose.pose;
  write(drive.truth, near);
  EXPECT_FALSE(holds(output_of("--align"), "lever-arm"));
}

TEST_F(EvaluateTrajectoryCommand, SaysOverWhatTheRelativeErrorIs) {
  write(drive_, drive_);
  EXPECT_TRUE(holds(output_of("--delta 25"), "RPE translation, 25 m"));
  EXPECT_TRUE(holds(output_of("--delta 0"), "RPE rotation, each step"));
}

// No error over ten metres was measured, which is not one of zero.
TEST_F(EvaluateTrajectoryCommand, SaysThatThePathIsTooShortForTheRelativeError) {
  Trajectory beginning = drive_;
  beginning.poses.resize(5);
  write(beginning, beginning);
  const std::string said = output_of("--json" + file("figures.json"));
  EXPECT_TRUE(holds(said, "RPE translation, 10 m    the path is shorter than 10 m"));
  EXPECT_TRUE(holds(said, "APE translation          rmse    0.0000"));
  const std::string figures = test::content_of(folder_.path() / "figures.json");
  EXPECT_TRUE(holds(figures, "\"rmse\": null"));
  EXPECT_TRUE(holds(figures, "\"translation_percent\": null"));
}

// A truth of 1 Hz is not interpolated.
TEST_F(EvaluateTrajectoryCommand, SaysWhatLiesInGapsOfTheTruth) {
  Trajectory sparse = drive_;
  sparse.poses.clear();
  for (std::size_t i = 10; i < drive_.poses.size(); i += 10)
    sparse.poses.push_back(drive_.poses[i]);
  write(sparse, drive_);
  const std::string said = output_of("--json" + file("figures.json"));
  EXPECT_TRUE(holds(said, "49 poses, "));
  EXPECT_TRUE(
      holds(said, "left out: 432 lie in gaps of the truth longer than 0.5 s, 19 lie before"));
  EXPECT_TRUE(holds(test::content_of(folder_.path() / "figures.json"), "\"in_gaps\": 432"));
  EXPECT_FALSE(holds((write(drive_, drive_), output_of("")), "left out"));
}

TEST_F(EvaluateTrajectoryCommand, AlignsByTheFirstPosesAlone) {
  Trajectory bent = drive_;
  for (std::size_t i = 100; i < bent.poses.size(); ++i) bent.poses[i].pose.translation.z() += 1.0;
  write(drive_, bent);
  const std::string said = output_of("--align --n-to-align 100");
  const std::string largest = "max    1.0000  m\nAPE rotation";
  EXPECT_TRUE(holds(said, largest));
  EXPECT_FALSE(holds(output_of("--align"), largest));
}

TEST_F(EvaluateTrajectoryCommand, PlotsToAnyName) {
  write(drive_, drive_);
  output_of("--plot \"" + (folder_.path() / "it's here.png").string() + "\"");
  EXPECT_TRUE(fs::exists(folder_.path() / "it's here.png"));
}

}  // namespace
}  // namespace lidar_mapping::tools
