// SPDX-License-Identifier: BSD-3-Clause
#include <GeographicLib/LocalCartesian.hpp>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/session_merger.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/session/imported_map.hpp"

#include "near.hpp"
#include "temporary_folder.hpp"
#include "town_session.hpp"

namespace lidar_mapping::pipeline::test {
namespace {

using lidar_mapping::test::near;
using lidar_mapping::test::TemporaryFolder;
using session::Session;

SessionMerger merger_into(const TemporaryFolder& folder) {
  return {Session::create_in(folder.path() / "merged"), {}, {}};
}

Session merged_session(const TemporaryFolder& folder) {
  return Session::open(folder.path() / "merged", Session::Access::kRead);
}

/// Largest error of the positions relative to the first key frame, m.
double largest_error(const KeyFramePoses& poses, const std::vector<Pose>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    const Pose expected = truth.front().inverse() * truth[i];
    largest =
        std::max(largest, (poses.poses[i].T_map_base.translation - expected.translation).norm());
  }
  return largest;
}

/// Two drives through one town that share two streets.
struct TwoDrives {
  ToyWorld world = make_town(110.0, 60.0, 4);
  std::vector<Pose> first = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {10, 0}});
  std::vector<Pose> second = along({{60, -40}, {60, 60}, {-40, 60}});
};

TEST(SessionMerger, MergesTwoDrivesThroughOneTown) {
  const TwoDrives drives;
  const TemporaryFolder folder;
  Session first = record_drive(folder.path() / "a", drives.world, drives.first,
                               drifting(drives.first, 1.001, 2e-4));
  const auto last = static_cast<KeyFrameIndex>(drives.first.size() - 1);
  Loop closing;
  closing.from = 1;
  closing.to = last;
  closing.T_from_to = drives.first[1].inverse() * drives.first[last];
  closing.covariance = diagonal_covariance(0.02, 0.002);
  first.add_loop(closing);
  first.set_loop_decision(1, last, LoopDecision::kAccept);
  // Equal stamps, as from two vehicles or from a simulation.
  const Session second = record_drive(folder.path() / "b", drives.world, drives.second,
                                      drifting(drives.second, 0.999, -2e-4));
  {
    SessionMerger merger = merger_into(folder);
    merger.add(first);
    merger.add(second);
    merger.finish();
    ASSERT_EQ(merger.parts().size(), 2U);
    EXPECT_TRUE(merger.parts()[1].is_connected);
    EXPECT_GT(merger.parts()[1].new_loops, 5U);
    EXPECT_EQ(merger.parts()[1].first, last + 1);
    EXPECT_EQ(merger.parts()[1].stamp_offset, 1);
  }
  const Session merged = merged_session(folder);
  std::vector<Pose> truth = drives.first;
  truth.insert(truth.end(), drives.second.begin(), drives.second.end());
  const KeyFramePoses poses = merged.poses();
  ASSERT_EQ(poses.poses.size(), truth.size());
  EXPECT_LT(largest_error(poses, truth), 0.5) << "metres by odometry alone";
  EXPECT_EQ(merged.loops().front().decision, LoopDecision::kAccept);
  EXPECT_EQ(merged.clouds().cloud(last + 3)->size(), second.clouds().cloud(2)->size());
  EXPECT_TRUE(std::filesystem::equivalent(merged.clouds().file(last + 3), second.clouds().file(2)));
  EXPECT_TRUE(merged.sensor_origin());
  EXPECT_GT(std::filesystem::file_size(folder.path() / "merged/trajectory/optimized.tum"), 100U);
}

using Pairs = std::multiset<std::pair<KeyFrameIndex, KeyFrameIndex>>;

/// A drive around a block, with the loops that the search finds where it returns to its start.
Session record_drive_around_a_block(const std::filesystem::path& folder, const ToyWorld& world) {
  const auto path = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {40, 0}});
  Session session = record_drive(folder, world, path, path);
  loop_closing::LoopCloser closer({}, session.clouds());
  closer.set_sensor_origin(ToyWorld::sensor());
  for (const KeyFrame& key_frame : session.key_frames()) {
    for (const Loop& loop : closer.process(key_frame).loops) session.add_loop(loop);
  }
  return session;
}

/// Pairs of key frames of the loops in the graph of a merged session.
Pairs loops_in_graph(const TemporaryFolder& folder) {
  Pairs pairs;
  const auto file = pose_graph::read_g2o((folder.path() / "merged/graph.g2o").string());
  for (const auto& edge : file.graph.edges) {
    if (edge.to != edge.from + 1) pairs.emplace(edge.from, edge.to);
  }
  return pairs;
}

// The search finds them again where the drive is merged.
TEST(SessionMerger, KeepsTheLoopsOfALaterDriveAsTheyAre) {
  const ToyWorld world = make_town(110.0, 60.0, 4);
  const auto elsewhere = along({{-60, -60}, {-60, 60}});
  const TemporaryFolder folder;
  const Session first = record_drive(folder.path() / "a", world, elsewhere, elsewhere);
  Session second = record_drive_around_a_block(folder.path() / "b", world);
  const std::vector<Loop> own = second.loops();
  ASSERT_GT(own.size(), 1U);
  second.set_loop_decision(own[0].from, own[0].to, LoopDecision::kRefuse);
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second);
  merger.finish();
  const KeyFrameIndex begin = merger.parts()[1].first;
  const Pairs pairs = loops_in_graph(folder);
  for (const auto& pair : pairs) EXPECT_EQ(pairs.count(pair), 1U) << "once";
  EXPECT_EQ(pairs.count({begin + own[0].from, begin + own[0].to}), 0U) << "a person refused it";
  EXPECT_EQ(pairs.count({begin + own[1].from, begin + own[1].to}), 1U);
  const Session merged = merged_session(folder);
  EXPECT_EQ(merged.loops().size(), own.size() + merger.parts()[1].new_loops);
  EXPECT_EQ(merged.revisions().back().loops_used, pairs.size());
  EXPECT_EQ(newest_verdicts(merged.verdicts()).at({begin + own[0].from, begin + own[0].to}).reason,
            "a person refused it");
}

// Of the walls the second LiDAR sees what is too high for the first one.
TEST(SessionMerger, JoinsTheDrivesOfLidarsThatSeeOtherElevations) {
  const TwoDrives drives;
  const TemporaryFolder folder;
  const Session first =
      record_drive(folder.path() / "a", seen_downwards(drives.world), drives.first, drives.first);
  const Session second =
      record_drive(folder.path() / "b", drives.world, drives.second, drives.second);
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second);
  merger.finish();
  EXPECT_TRUE(merger.parts()[1].is_connected);
  EXPECT_GT(merger.parts()[1].new_loops, 5U);
}

TEST(SessionMerger, ReportsUnconnectedDrives) {
  const TemporaryFolder folder;
  const ToyWorld here = make_town(60.0, 60.0, 4);
  const ToyWorld elsewhere = make_town(60.0, 60.0, 5);
  const auto path = along({{-40, 0}, {40, 0}});
  const Session first = record_drive(folder.path() / "a", here, path, path);
  const Session second = record_drive(folder.path() / "b", elsewhere, path, path, kStart + 1);
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second);
  merger.finish();
  EXPECT_TRUE(merger.parts()[0].is_connected);
  EXPECT_FALSE(merger.parts()[1].is_connected);
  EXPECT_EQ(merger.parts()[1].new_loops, 0U);
}

const GeodeticDatum kFirstDatum{49.0, 8.4, 110.0};
const GeodeticDatum kSecondDatum{49.01, 8.41, 118.0};

/// A drive without clouds that begins 300 m east of the first datum for each `number`.
Session drive_with_gnss(const std::filesystem::path& folder, int number,
                        const std::optional<GeodeticDatum>& datum) {
  using GeographicLib::LocalCartesian;
  const GeodeticDatum own = datum.value_or(kFirstDatum);
  const LocalCartesian first(kFirstDatum.latitude_deg, kFirstDatum.longitude_deg,
                             kFirstDatum.altitude_m);
  const LocalCartesian local(own.latitude_deg, own.longitude_deg, own.altitude_m);
  Session session = Session::create_in(folder);
  if (datum) session.set_datum(*datum);
  const auto path =
      along({{300.0 * number, 0.0}, {300.0 * number + 60.0, 0.0}, {300.0 * number + 60.0, 60.0}});
  for (std::size_t i = 0; i < path.size(); ++i) {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.stamp = kStart + number * 1'000'000'000'000 + static_cast<Stamp>(i) * 200'000'000;
    key_frame.T_odom_base = path.front().inverse() * path[i];
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    session.add_key_frame(key_frame);
    double latitude, longitude, altitude;
    const Eigen::Vector3d& p = path[i].translation;
    first.Reverse(p.x(), p.y(), p.z(), latitude, longitude, altitude);
    GnssPosition position;
    position.stamp = key_frame.stamp;
    local.Forward(latitude, longitude, altitude, position.p_enu_antenna.x(),
                  position.p_enu_antenna.y(), position.p_enu_antenna.z());
    position.covariance = 0.01 * Eigen::Matrix3d::Identity();
    session.add_gnss(position);
  }
  return session;
}

TEST(SessionMerger, GnssConnectsDrivesWithDifferentDatums) {
  const TemporaryFolder folder;
  const Session first = drive_with_gnss(folder.path() / "a", 0, kFirstDatum);
  const Session second = drive_with_gnss(folder.path() / "b", 1, kSecondDatum);
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second);
  merger.finish();
  EXPECT_TRUE(merger.parts()[1].is_connected);
  const Session merged = merged_session(folder);
  EXPECT_EQ(merged.datum(), kFirstDatum);
  const auto poses = merged.poses().poses;
  const Eigen::Vector3d& begin = poses[merger.parts()[1].first].T_map_base.translation;
  EXPECT_TRUE(near(begin, Eigen::Vector3d(300.0, 0.0, 0.0), 0.1)) << begin.transpose();
}

/// A straight drive with a scan every 0.1 s and a key frame at every second one from `first_key`
/// on. The front end has doubted the scans from number 10 to 19 if `is_doubted`.
Session drive_with_scans(const std::filesystem::path& folder, std::size_t first_key,
                         bool is_doubted) {
  Session session = Session::create_in(folder);
  constexpr std::size_t kScans = 40;
  for (std::size_t i = 0; i < kScans; ++i) {
    session::ScanRecord scan;
    scan.stamp = kStart + static_cast<Stamp>(i) * from_seconds(0.1);
    scan.state = is_doubted && i >= 10 && i < 20 ? "degraded" : "tracking";
    session.add_scan(scan);
    KeyFrame key_frame;
    key_frame.T_odom_base.translation.x() = static_cast<double>(i);
    session.add_odometry(scan.stamp, key_frame.T_odom_base);
    if (i % 2 != first_key) continue;
    key_frame.index = static_cast<KeyFrameIndex>(i / 2);
    key_frame.stamp = scan.stamp;
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    session.add_key_frame(key_frame);
  }
  return session;
}

/// Number of scans in the sections of this kind in the file of a merged session.
std::size_t doubted_scans(const TemporaryFolder& folder, Doubt doubt) {
  std::size_t scans = 0;
  for (const auto& section : read_doubt(folder.path() / "merged/doubt.csv").sections) {
    if (section.doubt == doubt) scans += section.scans;
  }
  return scans;
}

// The key frames of one drive have the stamps of scans of the other one that are no key frames.
TEST(SessionMerger, KeepsTheDoubtfulSectionsOfALaterDrive) {
  const TemporaryFolder folder;
  const Session first = drive_with_scans(folder.path() / "a", 0, false);
  const Session second = drive_with_scans(folder.path() / "b", 1, true);
  {
    SessionMerger merger = merger_into(folder);
    merger.add(first);
    merger.add(second);
    merger.finish();
    EXPECT_EQ(merger.parts()[1].stamp_offset, 1);
  }
  const Session merged = merged_session(folder);
  EXPECT_EQ(merged.scans().size(), first.scans().size() + second.scans().size());
  EXPECT_EQ(merged.odometry().size(), merged.scans().size());
  EXPECT_EQ(doubted_scans(folder, Doubt::kDegraded), 10U);
}

// Both begin at the same time.
TEST(SessionMerger, TellsScansOfDrivesApartThatOverlapInTime) {
  const TemporaryFolder folder;
  const Session first = drive_with_scans(folder.path() / "a", 0, false);
  const Session second = drive_with_scans(folder.path() / "b", 0, false);
  {
    SessionMerger merger = merger_into(folder);
    merger.add(first);
    merger.add(second);
    merger.finish();
  }
  const std::vector<session::ScanOdometry> merged = merged_session(folder).odometry();
  ASSERT_EQ(merged.size(), 80U);
  for (std::size_t i = 0; i < merged.size(); ++i) EXPECT_EQ(merged[i].drive, i % 2) << i;
  const DriveDoubt doubt = read_doubt(folder.path() / "merged/doubt.csv");
  EXPECT_NEAR(doubt.path_length, 2.0 * 39.0, 0.01);
}

// Without clouds nothing else could join them.
TEST(SessionMerger, JoinsADriveByTiesThatAreKnown) {
  const TemporaryFolder folder;
  const Session first = drive_with_scans(folder.path() / "a", 0, false);
  const Session second = drive_with_scans(folder.path() / "b", 0, false);
  std::vector<Loop> ties;
  for (const KeyFrameIndex index : {2U, 5U, 8U}) {
    Loop tie;
    tie.from = index;
    tie.to = index;
    tie.T_from_to.translation.y() = 3.0;
    tie.covariance = diagonal_covariance(0.02, 0.002);
    ties.push_back(tie);
  }
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second, ties);
  merger.finish();
  EXPECT_TRUE(merger.parts()[1].is_connected);
  EXPECT_EQ(merger.parts()[1].new_loops, 0U);
  const KeyFrameIndex begin = merger.parts()[1].first;
  const Session merged = merged_session(folder);
  ASSERT_EQ(merged.loops().size(), 3U);
  EXPECT_EQ(merged.loops().front().from, 2U);
  EXPECT_EQ(merged.loops().front().to, begin + 2U);
  const auto poses = merged.poses().poses;
  for (KeyFrameIndex i = 0; i < begin; ++i) {
    const Eigen::Vector3d beside = poses[i].T_map_base.translation + Eigen::Vector3d(0.0, 3.0, 0.0);
    EXPECT_TRUE(near(poses[begin + i].T_map_base.translation, beside, 0.01)) << i;
  }
}

TEST(SessionMerger, ReportsPositionsWithoutDatum) {
  const TemporaryFolder folder;
  const Session first = drive_with_gnss(folder.path() / "a", 0, kFirstDatum);
  const Session second = drive_with_gnss(folder.path() / "b", 1, std::nullopt);
  SessionMerger merger = merger_into(folder);
  merger.add(first);
  merger.add(second);
  merger.finish();
  EXPECT_FALSE(merger.parts()[1].is_connected);
  ASSERT_EQ(merger.parts()[1].notices.size(), 1U);
  EXPECT_NE(merger.parts()[1].notices[0].find("datum"), std::string::npos);
}

// It lies in the frame of its datum without any position.
TEST(SessionMerger, KeepsTheDatumOfAnImportedMap) {
  const TemporaryFolder folder;
  Session map = drive_with_scans(folder.path() / "a", 0, false);
  map.set_datum(kFirstDatum);
  map.set_configuration(session::kImportedMap, "map: town.pcd\n");
  const Session drive = drive_with_gnss(folder.path() / "b", 1, kSecondDatum);
  SessionMerger merger = merger_into(folder);
  merger.add(map);
  merger.add(drive);
  merger.finish();
  const Session merged = merged_session(folder);
  EXPECT_EQ(merged.datum(), kFirstDatum);
  ASSERT_FALSE(merged.gnss().empty());
  EXPECT_TRUE(near(merged.gnss().front().p_enu_antenna, Eigen::Vector3d(300.0, 0.0, 0.0), 0.1));
}

}  // namespace
}  // namespace lidar_mapping::pipeline::test
