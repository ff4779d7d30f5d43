// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/map_extender.hpp"
#include "lidar_mapping/session/session.hpp"

#include "near.hpp"
#include "street_drive.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline::test {
namespace {

namespace fs = std::filesystem;
using lidar_mapping::test::near;
using lidar_mapping::test::TemporaryFolder;
using session::Session;

constexpr double kTolerance = 0.01;  // m; nothing contradicts, so only the solver's ends count

/// The map of a street without clouds, so that loop closing finds nothing.
class MapExtenderTest : public testing::Test {
 protected:
  MapExtenderTest() {
    Session session = Session::create_in(map());
    for (const KeyFramePose& pose : street_map().poses) {
      KeyFrame key_frame;
      key_frame.index = pose.index;
      key_frame.stamp = pose.stamp;
      key_frame.T_odom_base = pose.T_map_base;
      key_frame.motion_covariance = diagonal_covariance(0.01, 0.001);
      session.add_key_frame(key_frame);
    }
    session::RevisionRecord record;
    record.revision = street_map().revision;
    session.set_poses(street_map(), record);
  }

  fs::path map() const { return folder_.path() / "map"; }
  fs::path extended() const { return folder_.path() / "extended"; }

  /// Adds a part of a drive of which each scan is a key frame.
  static void add(const std::vector<LocalizedKeyFrame>& drive, MapExtender& extender) {
    for (const LocalizedKeyFrame& scan : drive) {
      const Stamp stamp = scan.key_frame.stamp;
      session::ScanRecord record;
      record.stamp = stamp;
      record.state = "tracking";
      extender.add_scan(record);
      extender.add_odometry(stamp, scan.key_frame.T_odom_base);
      extender.add_key_frame(scan.key_frame, scan.place);
    }
  }
  ExtensionReport extend(const std::vector<LocalizedKeyFrame>& drive) const {
    MapExtender extender(map(), folder_beside(extended()));
    add(drive, extender);
    return extender.write(extender.drive(), extended());
  }
  /// Names of what lies in the folder of the map.
  std::vector<std::string> left_behind() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  static Session opened(const fs::path& folder) {
    return Session::open(folder, Session::Access::kRead);
  }

  const TemporaryFolder folder_;
};

// The map has 51 key frames. Of the drive 15 before its end and the 20 behind it are added.
TEST_F(MapExtenderTest, AddsWhatIsNewAndLeavesTheMapWhereItIs) {
  const ExtensionReport report = extend(street_drive(times(30, 'f') + times(20, 'b'), 20));
  ASSERT_TRUE(report.is_written());
  EXPECT_EQ(report.key_frames, 35U);
  EXPECT_LT(report.largest_move, kTolerance);
  const Session session = opened(extended());
  const KeyFramePoses poses = session.poses();
  ASSERT_EQ(poses.poses.size(), 51U + 35U);
  for (std::size_t i = 0; i < 51; ++i) {
    EXPECT_TRUE(near(poses.poses[i].T_map_base, street_map().poses[i].T_map_base, kTolerance));
  }
  for (std::size_t i = 0; i < 35; ++i) {
    const Pose truth = on_street(street_length(35 + static_cast<int>(i)), 1.0);
    EXPECT_TRUE(near(poses.poses[51 + i].T_map_base, truth, kTolerance)) << i;
  }
  EXPECT_EQ(opened(map()).key_frame_count(), 51U);
  EXPECT_EQ(left_behind(), (std::vector<std::string>{"extended", "map"}));
}

TEST_F(MapExtenderTest, StoresTiesAsLoopsAndTheSectionAsASegmentOfItsOwn) {
  ASSERT_TRUE(extend(street_drive(times(30, 'f') + times(20, 'b'), 20)).is_written());
  const Session session = opened(extended());
  const std::vector<Loop> loops = session.loops();
  ASSERT_EQ(loops.size(), 5U);
  EXPECT_EQ(loops.front().from, 35U);
  EXPECT_EQ(loops.front().to, 51U + 15U);  // the drive's own numbers behind those of the map
  const std::vector<KeyFrame> key_frames = session.key_frames();
  EXPECT_EQ(key_frames.back().index, 51U + 49U);
  EXPECT_NE(key_frames.front().segment, key_frames.back().segment);
  EXPECT_EQ(session.scans().size(), 35U);
  EXPECT_EQ(session.odometry().size(), 35U);
  const auto verdicts = newest_verdicts(session.verdicts());
  for (const Loop& loop : loops) {
    EXPECT_EQ(verdicts.at({loop.from, loop.to}).verdict, Verdict::kAccepted) << loop.to;
  }
}

// Each tie says something else, by metres, and odometry agrees with one of them at most.
TEST_F(MapExtenderTest, LeavesOutASectionWhoseTiesContradictEachOther) {
  auto drive = street_drive(times(30, 'f') + times(20, 'b'), 20);
  double shift = 4.0;
  for (const std::size_t tied : {15, 18, 21, 24, 27}) {
    drive[tied].place.T_map_base.translation.y() += shift;
    shift *= -1.5;
  }
  const ExtensionReport report = extend(drive);
  EXPECT_FALSE(report.is_written());
  EXPECT_NEAR(report.extension.omitted.not_tied, street_length(20), 1e-6);
  EXPECT_EQ(left_behind(), std::vector<std::string>{"map"});
}

// The first half of what is new is written while the drive goes on.
TEST_F(MapExtenderTest, WritesWhatThereIsSoFarAsOftenAsItIsAsked) {
  const auto drive = street_drive(times(30, 'f') + times(40, 'b'), 20);
  const auto middle = drive.begin() + 50;
  MapExtender extender(map(), folder_beside(extended()));
  add({drive.begin(), middle}, extender);
  const LocalizedDrive half = extender.drive();
  add({middle, drive.end()}, extender);
  EXPECT_EQ(extender.write(half, extended()).key_frames, 35U);
  const fs::path whole = folder_.path() / "whole";
  EXPECT_EQ(extender.write(extender.drive(), whole).key_frames, 55U);
  EXPECT_EQ(opened(extended()).key_frame_count(), 51U + 35U);
  EXPECT_EQ(opened(whole).key_frame_count(), 51U + 55U);
  EXPECT_EQ(opened(whole).scans().size(), 55U);
  EXPECT_THROW(extender.write(extender.drive(), whole), FileError) << "it exists";
}

TEST_F(MapExtenderTest, TakesTheCloudsOfWhatIsNew) {
  auto drive = street_drive(times(30, 'f') + times(20, 'b'), 20);
  PointCloud points;
  points.points.push_back({1.0F, 2.0F, 3.0F, 0.5F});
  for (const std::size_t i : {0, 40}) {
    drive[i].key_frame.cloud = std::make_shared<const PointCloud>(points);
  }
  ASSERT_TRUE(extend(drive).is_written());
  const Session session = opened(extended());
  const PointCloudPtr cloud = session.clouds().cloud(51 + 40);
  ASSERT_NE(cloud, nullptr);
  ASSERT_EQ(cloud->size(), 1U);
  EXPECT_EQ(cloud->points.front().y, 2.0F);
  EXPECT_FALSE(session.clouds().contains(51)) << "the map knows what lies there";
}

// Three places were claimed: a right one, none, and one that a person says is wrong.
TEST_F(MapExtenderTest, DiscardsAPlaceThatAPersonWithdraws) {
  MapExtender extender(map(), folder_beside(extended()));
  add(street_drive(times(5, 'f') + times(2, 's') + times(3, 'f') + "b", 20), extender);
  extender.withdraw_places(extender.drive().key_frames[7].key_frame.stamp);
  for (std::size_t i = 0; i < 11; ++i) {
    const bool has_pose = localization::has_pose(extender.drive().key_frames[i].place.state);
    EXPECT_EQ(has_pose, i < 5) << i;
  }
}

TEST_F(MapExtenderTest, WritesNothingWhereNothingIsNew) {
  const ExtensionReport report = extend(street_drive(times(30, 'f'), 10));
  EXPECT_FALSE(report.is_written());
  EXPECT_EQ(report.key_frames, 0U);
  EXPECT_EQ(left_behind(), std::vector<std::string>{"map"});
}

TEST_F(MapExtenderTest, RefusesAMapWhoseGraphUsesNoLoops) {
  {
    Session session = Session::open(map(), Session::Access::kWrite);
    session.set_configuration("back_end", "use_loop_close: false\n");
  }
  EXPECT_THROW(MapExtender(map(), folder_beside(extended())), InputError);
  EXPECT_EQ(left_behind(), std::vector<std::string>{"map"});
}

}  // namespace
}  // namespace lidar_mapping::pipeline::test
