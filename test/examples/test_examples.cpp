// SPDX-License-Identifier: BSD-3-Clause
// The programs of examples/, run as a user runs them, against what is known of their input.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/session/session.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "near.hpp"
#include "program.hpp"
#include "simulated_key_frames.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

namespace fs = std::filesystem;

constexpr double kBegin = 10.0;  // s after the drive's beginning: the vehicle is in motion by then
constexpr double kEnd = 16.0;

/// A drive through a street in which nothing else moves; each scan is taken in an instant, with 2
/// cm of range noise.
const simulation::Drive& still_street() {
  static const simulation::Drive drive = [] {
    simulation::DriveOptions options;
    options.lidar = "vlp16";
    options.movers = false;
    options.undistorted = true;
    options.start = kBegin;
    options.duration = kEnd;
    return simulation::Drive(options);
  }();
  return drive;
}

Pose true_lidar_pose(const simulation::Drive& drive, std::size_t scan) {
  return drive.trajectory().pose(drive.scan_stamp(scan)) * drive.mounting().T_base_lidar;
}

class Example : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }

  /// What the example says; it has to end well.
  std::string output_of(const std::string& example, const test::Words& words) const {
    test::Program program(example, words, folder_.path() / "output");
    const int status = program.wait();
    EXPECT_EQ(status, 0) << example << ": " << program.output();
    return program.output();
  }

  /// The `count` numbers that follow `words` in a text; numbers missing there are NaN.
  static std::vector<double> numbers_after(const std::string& words, const std::string& text,
                                           std::size_t count) {
    std::vector<double> numbers(count, std::nan(""));
    const std::size_t begin = text.find(words);
    EXPECT_NE(begin, std::string::npos) << "'" << words << "' is not in: " << text;
    if (begin == std::string::npos) return numbers;
    std::istringstream stream(text.substr(begin + words.size()));
    for (double& number : numbers) stream >> number;
    return numbers;
  }
  static double number_after(const std::string& words, const std::string& text) {
    return numbers_after(words, text, 1).front();
  }

  const test::TemporaryFolder folder_;
};

TEST_F(Example, OdometryOfFolderFollowsADrive) {
  const simulation::Drive& drive = still_street();
  // Where FolderInput takes the LiDAR to be: 1.73 m above base_link.
  const Pose T_lidar_base{Eigen::Quaterniond::Identity(), {0.0, 0.0, -1.73}};
  fs::create_directory(folder_.path() / "scans");
  Trajectory truth;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "scans/%06zu.pcd", i);
    session::write_pcd(folder_.path() / name, drive.scan(i).cloud);
    truth.poses.push_back(
        {static_cast<Stamp>(i) * from_seconds(0.1), true_lidar_pose(drive, i) * T_lidar_base});
  }

  const std::string said = output_of("odometry_of_folder", {path("scans"), path("odometry.tum")});

  const Trajectory odometry = read_trajectory(path("odometry.tum"));
  EXPECT_NE(said.find(std::to_string(truth.poses.size()) + " poses"), std::string::npos) << said;
  ASSERT_EQ(odometry.poses.size(), truth.poses.size());
  auto pairs = evaluation::associate(truth, odometry);
  ASSERT_EQ(pairs.size(), truth.poses.size());
  pairs = evaluation::aligned(pairs, pairs.front().truth * pairs.front().estimate.inverse());
  const double way = evaluation::travelled_distances(pairs).back();
  EXPECT_GT(way, 20.0);
  // The first pose carries the error of a single match, which turns the whole way.
  EXPECT_LT(evaluation::absolute_pose_error(pairs).translation_m.max, 0.005 * way);
}

class RegisterTwoScans : public Example, public testing::WithParamInterface<std::string> {};

TEST_P(RegisterTwoScans, FindsTheTrueMotionToACentimetre) {
  const simulation::Drive& drive = still_street();
  constexpr std::size_t kTarget = 5;
  constexpr std::size_t kSource = 6;
  session::write_pcd(path("target.pcd"), drive.scan(kTarget).cloud);
  session::write_pcd(path("source.pcd"), drive.scan(kSource).cloud);
  const Pose truth = true_lidar_pose(drive, kTarget).inverse() * true_lidar_pose(drive, kSource);
  ASSERT_GT(truth.translation.norm(), 0.3);

  const std::string said =
      output_of("register_two_scans", {path("target.pcd"), path("source.pcd"), GetParam()});

  const std::vector<double> t = numbers_after("translation ", said, 3);
  const std::vector<double> r = numbers_after("rotation vector ", said, 3);
  const Pose found{exp_so3({r[0], r[1], r[2]}), {t[0], t[1], t[2]}};
  EXPECT_TRUE(test::near(found, truth, 0.01, 0.1 * kRadPerDeg)) << said;
}

// PCL's methods take planes from neighbours at a fixed number, which with 16 beams are those of
// rings.
INSTANTIATE_TEST_SUITE_P(Methods, RegisterTwoScans, testing::Values("NDT", "VGICP"));

TEST_F(Example, OwnFactorCorrectsTheDrift) {
  const std::string said = output_of("own_factor", {});
  EXPECT_NE(said.find("316 constraints"), std::string::npos)
      << said;  // 79 steps, each with 3 ranges
  EXPECT_GT(number_after("position error ", said), 2.0) << said;
  EXPECT_LT(number_after(" before, ", said), 0.05) << said;
}

TEST_F(Example, MapOfSessionIsTheMapOfItsKeyFrames) {
  const simulation::Drive& drive = still_street();
  test::SimulatedKeyFrames key_frames(drive, kBegin, kEnd, 5.0);
  session::create_filled(folder_.path() / "session", [&](session::Session& session) {
    for (const KeyFramePose& pose : key_frames.poses.poses) {
      KeyFrame key_frame;
      key_frame.index = pose.index;
      key_frame.stamp = pose.stamp;
      key_frame.T_odom_base = pose.T_map_base;
      key_frame.cloud = key_frames.cloud(pose.index);
      session.add_key_frame(key_frame);
    }
    session::RevisionRecord record;
    record.revision = key_frames.poses.revision = 1;
    session.set_poses(key_frames.poses, record);
  });

  const std::string said = output_of("map_of_session", {path("session"), path("map"), "0.5"});

  map::MapConfig config;
  config.resolution = 0.5;
  const PointCloud expected = map::build_map(key_frames.poses, key_frames, config);
  ASSERT_GT(expected.size(), 1000U);
  EXPECT_EQ(session::read_pcd(path("map/map.pcd")).size(), expected.size());
  EXPECT_NE(said.find(std::to_string(expected.size()) + " points of " +
                      std::to_string(key_frames.poses.poses.size()) + " key frames"),
            std::string::npos)
      << said;
  EXPECT_TRUE(fs::exists(path("map/map.las")));
  EXPECT_TRUE(fs::exists(path("map/top_view.png")));
}

/// A curve of 500 m, and an estimate that drifts and lies elsewhere.
TEST_F(Example, TrajectoryErrorsAreThoseOfEvaluateTrajectory) {
  Trajectory truth;
  Trajectory estimate;
  const Pose elsewhere{exp_so3({0.1, -0.2, 1.0}), {40.0, -3.0, 5.0}};
  for (int i = 0; i < 500; ++i) {
    const Stamp stamp = Stamp{i} * from_seconds(0.1);
    const Pose pose{exp_so3({0.0, 0.0, 0.7 * std::cos(i / 40.0)}),
                    {1.0 * i, 30.0 * std::sin(i / 40.0), 5.0 * std::sin(i / 90.0)}};
    const Pose drift{exp_so3({0.0, 0.0, 1e-5 * i}), {0.0, 1e-3 * i, 0.0}};
    truth.poses.push_back({stamp, pose});
    estimate.poses.push_back({stamp, elsewhere * drift * pose});
  }
  write("truth", to_tum(truth));
  write("estimate", to_tum(estimate));

  const std::string said = output_of("trajectory_errors", {path("truth"), path("estimate")});

  const std::string command = std::string(LIDAR_MAPPING_EVALUATE_TRAJECTORY) + " '" +
                              path("truth") + "' '" + path("estimate") + "' --align --json '" +
                              path("figures.json") + "' > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const auto expected = nlohmann::json::parse(std::ifstream(path("figures.json")));
  constexpr double kPrinted = 5.1e-7;  // six digits are printed
  EXPECT_GT(expected["ape"]["translation_m"]["rmse"], 0.01);
  for (const auto& [name, key] : {std::pair("APE", "ape"), std::pair("RPE over 10 m", "rpe")}) {
    const std::string line = said.substr(said.find(name));
    EXPECT_NEAR(number_after("translation RMSE ", line), expected[key]["translation_m"]["rmse"],
                kPrinted);
    EXPECT_NEAR(number_after("max ", line), expected[key]["translation_m"]["max"], kPrinted);
    EXPECT_NEAR(number_after("rotation RMSE ", line), expected[key]["rotation_deg"]["rmse"],
                kPrinted);
  }
  EXPECT_NEAR(number_after("KITTI: ", said), expected["kitti"]["translation_percent"], kPrinted);
  EXPECT_NEAR(number_after("%, ", said), expected["kitti"]["rotation_deg_per_100m"], kPrinted);
}

TEST_F(Example, MistakesEndWithASentence) {
  for (const char* name :
       {"odometry_of_folder", "register_two_scans", "map_of_session", "trajectory_errors"}) {
    test::Program program(name, {path("missing")}, folder_.path() / "output");
    EXPECT_EQ(program.wait(), 1) << name;
    EXPECT_EQ(program.output().rfind("usage: ", 0), 0U) << program.output();
  }
  test::Program no_number("map_of_session", {path("missing"), path("map"), "fine"},
                          folder_.path() / "output");
  EXPECT_EQ(no_number.wait(), 1);
  EXPECT_NE(no_number.output().find("resolution"), std::string::npos) << no_number.output();
  test::Program program("register_two_scans", {path("a.pcd"), path("b.pcd")},
                        folder_.path() / "output");
  EXPECT_EQ(program.wait(), 1);
  EXPECT_NE(program.output().find("a.pcd"), std::string::npos) << program.output();
}

}  // namespace
}  // namespace lidar_mapping
