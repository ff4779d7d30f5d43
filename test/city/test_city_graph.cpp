// SPDX-License-Identifier: BSD-3-Clause
// Drives through a toy town: pairs, loops, one graph.
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include "city_session.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"
#include "town_session.hpp"

namespace lidar_mapping::city::test {
namespace {

namespace fs = std::filesystem;
using lidar_mapping::test::TemporaryFolder;
using pipeline::test::along;
using pipeline::test::drifting;
using pipeline::test::kStart;
using pipeline::test::make_town;
using pipeline::test::record_drive;
using session::Session;

const GeodeticDatum kDatum{49.0, 8.4, 110.0};

Session opened(const fs::path& folder) { return Session::open(folder, Session::Access::kRead); }

/// Positions at all key frames, `offset` (m) beside the truth.
void add_gnss(const fs::path& folder, const std::vector<Pose>& truth,
              const Eigen::Vector3d& offset) {
  Session session = Session::open(folder, Session::Access::kWrite);
  session.set_datum(kDatum);
  KeyFramePoses poses;
  poses.revision = 1;
  const auto key_frames = session.key_frames();
  for (std::size_t i = 0; i < key_frames.size(); ++i) {
    GnssPosition position;
    position.stamp = key_frames[i].stamp;
    position.p_enu_antenna = truth[i].translation + offset;
    position.covariance = 0.25 * Eigen::Matrix3d::Identity();
    session.add_gnss(position);
    Pose T_map_base = truth[i];
    T_map_base.translation += offset;
    poses.poses.push_back({key_frames[i].index, key_frames[i].stamp, T_map_base});
  }
  session::RevisionRecord record;
  record.revision = poses.revision;
  session.set_poses(poses, record);
}

/// Three drives through the same two streets and one elsewhere.
class CityGraph : public ::testing::Test {
 protected:
  fs::path record(const std::string& name, const std::vector<Pose>& truth, double scale,
                  double turn) {
    record_drive(path(name), world_, truth, drifting(truth, scale, turn), kStart + next_++);
    truths_[name] = truth;
    return path(name);
  }
  fs::path path(const std::string& name) const { return folder_.path() / name; }

  /// Loops of two drives as the jobs find them.
  std::vector<PairLoops> search(const std::vector<std::string>& names) const {
    std::vector<DrivePieces> drives;
    for (const std::string& name : names)
      drives.push_back(describe_drive(opened(path(name)), name));
    std::vector<PairLoops> loops;
    for (const Chunk& chunk : find_chunks(drives)) {
      loops.push_back(search_chunk(opened(path(chunk.a)), opened(path(chunk.b)), chunk, {}, {},
                                   folder_.path()));
    }
    return loops;
  }

  JoinedCity join(const std::vector<std::string>& names,
                  const std::vector<PairLoops>& loops) const {
    std::vector<fs::path> sessions;
    for (const std::string& name : names) sessions.push_back(path(name));
    return join_drives(sessions, loops, std::nullopt, {});
  }

  /// Largest error of a loop against the truth, m.
  double largest_error(const PairLoops& pair) const {
    double largest = 0.0;
    for (const Loop& loop : pair.loops) {
      const Pose expected = truths_.at(pair.a)[loop.from].inverse() * truths_.at(pair.b)[loop.to];
      largest = std::max(largest, (expected.translation - loop.T_from_to.translation).norm());
    }
    return largest;
  }

  /// Largest error of the distance between key frames of both drives that are less than 2 m apart,
  /// m; `poses` are those of the square and then those of the crossing.
  double largest_gap(const std::vector<KeyFramePose>& poses) const {
    double largest = 0.0;
    for (std::size_t i = 0; i < square_.size(); ++i) {
      for (std::size_t k = 0; k < crossing_.size(); ++k) {
        const double expected = (square_[i].translation - crossing_[k].translation).norm();
        if (expected > 2.0) continue;
        const Eigen::Vector3d& a = poses[i].T_map_base.translation;
        const Eigen::Vector3d& b = poses[square_.size() + k].T_map_base.translation;
        largest = std::max(largest, std::abs((a - b).norm() - expected));
      }
    }
    return largest;
  }

  const std::vector<Pose> square_ = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}});
  const std::vector<Pose> crossing_ = along({{60, -40}, {60, 60}, {-40, 60}});
  pipeline::test::ToyWorld world_ = make_town(110.0, 60.0, 4);
  TemporaryFolder folder_;
  std::map<std::string, std::vector<Pose>> truths_;
  Stamp next_ = 0;
};

TEST_F(CityGraph, DrivesWithoutGnssAreConnectedByLoops) {
  record("a", square_, 1.001, 2e-4);
  record("b", crossing_, 0.999, -2e-4);
  const auto loops = search({"a", "b"});
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_GT(loops[0].loops.size(), 5U);
  EXPECT_LT(largest_error(loops[0]), 0.3);
  EXPECT_FALSE(loops[0].used_gnss);
  const JoinedCity city = join({"a", "b"}, loops);
  EXPECT_EQ(city.drives[1].state, DriveState::kJoined);
  EXPECT_GT(city.drives[1].loops.used, 5U);
  write_city(city, {}, path("city"));
  const auto poses = opened(path("city")).poses().poses;
  ASSERT_EQ(poses.size(), square_.size() + crossing_.size());
  EXPECT_LT(largest_gap(poses), 0.3) << "a street that both drove is there twice";
  const Trajectory b = read_trajectory((path("city") / "drives/b.tum").string());
  EXPECT_EQ(b.poses.front().stamp, kStart + 1) << "its own stamps";
  EXPECT_EQ(
      opened(path("city")).clouds().cloud(poses.back().index)->size(),
      opened(path("b")).clouds().cloud(poses.back().index - city.drives[1].offsets.index)->size());
}

TEST_F(CityGraph, ADriveElsewhereIsLeftOutAndNamed) {
  record("a", square_, 1.0, 0.0);
  world_ = make_town(60.0, 60.0, 9);
  record("b", along({{-40, 0}, {40, 0}}), 1.0, 0.0);
  const JoinedCity city = join({"a", "b"}, search({"a", "b"}));
  EXPECT_EQ(city.drives[0].state, DriveState::kJoined);
  EXPECT_EQ(city.drives[1].state, DriveState::kUnconnected);
  ASSERT_EQ(city.drives[1].notices.size(), 1U);
  EXPECT_NE(city.drives[1].notices[0].find("neither a loop nor GNSS connects"), std::string::npos);
  write_city(city, {}, path("city"));
  EXPECT_EQ(opened(path("city")).key_frame_count(), square_.size());
}

// The odometry of b was lost after half of the way, and nothing connects the rest of it.
TEST_F(CityGraph, KeepsTheDoubtsOfTheConnectedPartOfADrive) {
  record("a", square_, 1.0, 0.0);
  record("b", square_, 1.0, 0.0);
  const fs::path whole = path("b"), cut = path("cut");
  {
    const Session from = opened(whole);
    Session to = Session::create_in(cut);
    for (KeyFrame key_frame : from.key_frames()) {
      const bool is_connected = key_frame.index < 60;
      key_frame.segment = is_connected ? 0 : 1;
      key_frame.cloud = from.clouds().cloud(key_frame.index);
      to.add_key_frame(key_frame);
      session::ScanRecord scan;
      scan.stamp = key_frame.stamp;
      const bool is_degraded = key_frame.index % 60 >= 20 && key_frame.index % 60 < 30;
      scan.state = is_degraded ? "degraded" : "tracking";
      to.add_scan(scan);
      to.add_odometry(scan.stamp, key_frame.T_odom_base);
    }
    for (const auto& [a, b] : {std::pair(3U, 40U), {50U, 70U}, {70U, 90U}}) {
      LoopVerdict verdict;
      verdict.from = a;
      verdict.to = b;
      verdict.verdict = Verdict::kRefused;
      to.add_verdict(verdict);
    }
  }
  PairLoops loops;
  loops.a = "a";
  loops.b = "cut";
  for (KeyFrameIndex i = 0; i < 60; i += 5) {
    Loop loop;
    loop.from = loop.to = i;
    loop.covariance = diagonal_covariance(0.05, 0.002);
    loops.loops.push_back(loop);
  }
  const JoinedCity city = join({"a", "cut"}, {loops});
  ASSERT_EQ(city.drives[1].key_frames.size(), 60U);
  write_city(city, {}, path("city"));
  const auto doubt = pipeline::read_doubt(path("city") / "doubt.csv");
  ASSERT_EQ(doubt.sections.size(), 1U);
  EXPECT_EQ(doubt.sections[0].doubt, pipeline::Doubt::kDegraded);
  EXPECT_EQ(doubt.sections[0].scans, 10U);
  const Session joined = opened(path("city"));
  EXPECT_EQ(joined.scans().size(), 60U) << "not those of what was left out";
  EXPECT_EQ(joined.odometry().size(), 60U);
  std::size_t of_the_drive = 0;
  for (const LoopVerdict& verdict : joined.verdicts()) {
    const KeyFrameIndex first = city.drives[1].offsets.index;
    of_the_drive += verdict.verdict == Verdict::kRefused && verdict.from >= first ? 1 : 0;
    EXPECT_LT(verdict.to, first + 60) << "names a key frame that is not there";
  }
  EXPECT_EQ(of_the_drive, 1U);
}

TEST_F(CityGraph, GnssThatContradictsTheOthersIsLeftOutAndNamed) {
  for (const char* name : {"a", "b", "c"}) {
    record(name, square_, 1.0, 0.0);
    const Eigen::Vector3d offset(name[0] == 'b' ? 25.0 : 0.0, 0.0, 0.0);
    add_gnss(path(name), square_, offset);
  }
  const auto loops = search({"a", "b", "c"});
  for (const PairLoops& pair : loops) {
    EXPECT_GE(pair.loops.size(), 3U) << pair.a << pair.b << pair.used_gnss << pair.searched;
    EXPECT_LT(largest_error(pair), 0.3) << pair.a << pair.b;
  }
  const JoinedCity city = join({"a", "b", "c"}, loops);
  EXPECT_TRUE(city.drives[0].uses_gnss);
  EXPECT_FALSE(city.drives[1].uses_gnss);
  EXPECT_TRUE(city.drives[2].uses_gnss);
  ASSERT_EQ(city.drives[1].notices.size(), 1U);
  EXPECT_NE(city.drives[1].notices[0].find("25."), std::string::npos) << city.drives[1].notices[0];
  write_city(city, {}, path("city"));
  const auto poses = opened(path("city")).poses().poses;
  const Eigen::Vector3d& begin_of_b = poses[square_.size()].T_map_base.translation;
  EXPECT_TRUE(lidar_mapping::test::near(begin_of_b, square_.front().translation, 1.0));
}

TEST_F(CityGraph, ADriveWhoseLoopsContradictIsDetachedAndNamed) {
  for (const char* name : {"a", "b", "c"}) record(name, square_, 1.0, 0.0);
  PairLoops right, wrong, also_wrong;
  right.a = wrong.a = "a";
  right.b = also_wrong.a = "b";
  wrong.b = also_wrong.b = "c";
  for (KeyFrameIndex i = 0; i < 100; i += 10) {
    Loop loop;
    loop.from = loop.to = i;
    loop.covariance = diagonal_covariance(0.05, 0.002);
    right.loops.push_back(loop);
    // Of c every loop says something else.
    loop.T_from_to.translation.x() =
        3.0 * (i % 20 == 0 ? 1.0 : -1.0) + 0.2 * static_cast<double>(i);
    wrong.loops.push_back(loop);
    loop.T_from_to.translation.y() = 5.0 - 0.3 * static_cast<double>(i);
    also_wrong.loops.push_back(loop);
  }
  const JoinedCity city = join({"a", "b", "c"}, {right, wrong, also_wrong});
  EXPECT_EQ(city.drives[0].state, DriveState::kJoined);
  EXPECT_EQ(city.drives[1].state, DriveState::kJoined);
  EXPECT_EQ(city.drives[1].loops.used, 10U);
  EXPECT_EQ(city.drives[2].state, DriveState::kDetached);
  EXPECT_NE(city.drives[2].notices.at(0).find("contradicts"), std::string::npos);
  EXPECT_EQ(city.loops.size(), 10U);
}

TEST_F(CityGraph, LoopsOfAnUnknownDriveAreAnError) {
  record("a", square_, 1.0, 0.0);
  PairLoops loops;
  loops.a = "a";
  loops.b = "zebra";
  EXPECT_THROW(join({"a"}, {loops}), InputError);
}

// As of a session that was made again after its loops were searched.
TEST_F(CityGraph, LoopsOfUnknownKeyFramesAreAnError) {
  for (const char* name : {"a", "b"}) record(name, square_, 1.0, 0.0);
  PairLoops loops;
  loops.a = "a";
  loops.b = "b";
  loops.loops.resize(1);
  EXPECT_NO_THROW(join({"a", "b"}, {loops}));
  loops.loops[0].from = static_cast<KeyFrameIndex>(square_.size());  // the first one of drive b
  EXPECT_THROW(join({"a", "b"}, {loops}), InputError);
}

}  // namespace
}  // namespace lidar_mapping::city::test
