// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <nlohmann/json.hpp>

#include "lidar_mapping/common/trajectory.hpp"

#include "localization/localize_files.hpp"
#include "localization_record.hpp"
#include "mapped_drive.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::holds;

class MapQualityCommand : public test::MappedDrive {
 protected:
  MapQualityCommand() { fs::copy(whole(), session_, fs::copy_options::recursive); }

  /// The lines that judge: the sentence on the whole and those on single figures.
  static std::string verdict() {
    const std::string text = said();
    const std::size_t begin = std::min(text.find("Good: "), text.find("Look at: "));
    return begin == std::string::npos ? "" : text.substr(begin, text.find('/', begin) - begin);
  }
  /// A true trajectory: that of the session, moved.
  std::string write_truth() const {
    Trajectory truth = read_trajectory(session_ / "trajectory" / "optimized.tum");
    const Pose elsewhere{exp_so3({0.0, 0.0, 1.0}), {100.0, 0.0, 3.0}};
    for (StampedPose& pose : truth.poses) pose.pose = elsewhere * pose.pose;
    const std::string file = folder_.path() / "truth.tum";
    std::ofstream(file) << to_tum(truth);
    return file;
  }

  /// The folder of localize_bag for a made-up drive of the next day where the map's was.
  fs::path write_drive_of_another_day() const {
    const auto session = opened(session_);
    std::vector<LocalizedScan> scans;
    for (const KeyFramePose& pose : session.poses().poses) {
      LocalizedScan scan;
      scan.result.stamp = pose.stamp + 86'400 * kNanosecondsPerSecond;
      scan.result.state = localization::LocalizationState::kFollowing;
      scan.result.T_map_base = pose.T_map_base;
      scan.result.agreement = 0.7;
      scan.result.coverage = 0.9;
      scan.T_odom_base = pose.T_map_base;
      const Eigen::Vector3d& p = pose.T_map_base.translation;
      if (!scans.empty()) {
        scan.path = scans.back().path + (p - scans.back().T_odom_base.translation).norm();
      }
      scans.push_back(scan);
    }
    const fs::path folder = folder_.path() / "tuesday";
    write_localization(folder, scans, std::nullopt);
    report::write_localization_record(
        folder, {{"tuesday.bag"}, report::identity_of(session.poses(), session_)});
    return folder;
  }

  const fs::path session_ = folder_.path() / "it's a session";
};

TEST_F(MapQualityCommand, JudgesWithAndWithoutAReport) {
  ASSERT_EQ(run("map_quality", {session_}), 0);
  const std::string without = verdict();
  EXPECT_TRUE(holds(without, "Walls")) << said();
  EXPECT_TRUE(holds(without, "Pose uncertainty")) << said();
  ASSERT_EQ(run("map_quality", {session_, "--report"}), 0);
  EXPECT_EQ(verdict(), without);
  std::ifstream stream(session_ / "report.json");
  const auto report = nlohmann::json::parse(stream);
  EXPECT_EQ(without.find(report["overall"].get<std::string>()), 0U) << report["overall"];
  EXPECT_TRUE(holds(content_of(session_ / "report.html"), report["overall"].get<std::string>()));
}

TEST_F(MapQualityCommand, WritesHowWellEachKeyFrameIsKnown) {
  const std::string file = folder_.path() / "key frames.csv";
  ASSERT_EQ(run("map_quality", {session_, "--key-frames", file}), 0);
  EXPECT_TRUE(has_said("m from the first key frame (key frame "));
  const std::string table = content_of(file);
  EXPECT_EQ(table.find("key_frame,stamp_ns,x,y,z,path_length_m,part,doubtful,sigma_first_m"), 0U)
      << table;
  EXPECT_GT(std::count(table.begin(), table.end(), '\n'), 5) << table;
  EXPECT_EQ(run("map_quality", {session_, "--key-frames", folder_.path()}), 1) << "a folder";
}

TEST_F(MapQualityCommand, ComparesWithTheTruthWithAndWithoutAReport) {
  const std::string truth = write_truth();
  for (const test::Words& words : {test::Words{session_, "--truth", truth},
                                   test::Words{session_, "--truth", truth, "--report"}}) {
    ASSERT_EQ(run("map_quality", words), 0);
    EXPECT_TRUE(has_said("Against the truth          APE 0 mm"));
  }
}

TEST_F(MapQualityCommand, MissesATruthThatIsNotThere) {
  for (const test::Words& words : {test::Words{session_, "--truth", "no_such.tum"},
                                   test::Words{session_, "--truth", "no_such.tum", "--report"}}) {
    EXPECT_EQ(run("map_quality", words), 1);
    EXPECT_TRUE(has_said("no_such.tum"));
  }
  const std::string other = folder_.path() / "other_day.tum";
  std::ofstream(other) << "1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n";
  EXPECT_EQ(run("map_quality", {session_, "--truth", other}), 1);
  EXPECT_TRUE(has_said("check the clocks"));
}

TEST_F(MapQualityCommand, ExaminesTheMapByAnotherDrive) {
  const std::string drive = write_drive_of_another_day();
  ASSERT_EQ(run("map_quality", {session_, "--examined-by", drive, "--report"}), 0);
  EXPECT_TRUE(has_said("examined by tuesday (tuesday.bag), "));
  EXPECT_TRUE(has_said("good      Examination by tuesday     100.0 % of "));
  const std::string page = content_of(session_ / "report.html");
  for (const char* part : {"Examination by other drives", "tuesday: tuesday.bag",
                           "The trajectory of the map. Grey", "over 10 m"}) {
    EXPECT_TRUE(holds(page, part));
  }
}

TEST_F(MapQualityCommand, RefusesADriveThatExaminesAnotherMap) {
  const std::string drive = write_drive_of_another_day();
  report::write_localization_record(drive, {{"tuesday.bag"}, report::identity_of({}, "friday")});
  EXPECT_EQ(run("map_quality", {session_, "--examined-by", drive}), 1);
  EXPECT_TRUE(has_said("it was localised in the map friday (0 key frames)"));
  EXPECT_EQ(run("map_quality", {session_, "--examined-by", session_}), 1);
  EXPECT_TRUE(has_said("there is no localization.json in"));
}

TEST_F(MapQualityCommand, SaysInTheReportWhereItComesFrom) {
  ASSERT_EQ(run("map_quality", {session_, "--report"}), 0);
  const std::string page = content_of(session_ / "report.html");
  for (const char* part :
       {"drive.bag", "/kitti/velo/pointcloud", "lidar_mapping 0.", "--threads 2", "East-North-Up",
        "map/map.pcd", "Extent of the map: x", "use_gnss: true", "Height above the ground"}) {
    EXPECT_TRUE(holds(page, part));
  }
  for (const char* part : {"way (m)", "Poses held", "left over"}) {
    EXPECT_FALSE(holds(page, part));
  }
}

}  // namespace
}  // namespace lidar_mapping::tools
