// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/pose_change.hpp"
#include "lidar_mapping/session/session.hpp"

#include "simulated_drives.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::content_of;
using test::Words;

/// The map of one street of a town and of half of the next one, and drives of other days that go on
/// beyond its end.
class ExtendMap : public test::SimulatedDrives {
 protected:
  static std::string bag(const std::string& name, const Words& words) {
    return simulated(name, joined({"--lidar", "vlp16"}, words));
  }
  /// Without the noise of GNSS, so that only what is added could move it.
  static fs::path map() {
    const fs::path session = root() / "map";
    if (fs::exists(session)) return session;
    const std::string drive = bag("mapping", {"--duration", "16"});
    EXPECT_EQ(run("map_bag",
                  {drive, "-o", session, "--no-map", "--parameter", "back_end/use_gnss: false"}),
              0);
    return session;
  }
  /// Through the map up to its end at 16 s and 100 m further.
  static std::string beyond() {
    return bag("beyond", {"--pass", "1", "--parked", "1", "--start", "3", "--duration", "32"});
  }
  static fs::path extended() {
    const fs::path session = root() / "extended";
    if (fs::exists(session)) return session;
    EXPECT_EQ(localize_in(map(), beyond(), root() / "beyond_in_map",
                          {"--extend", session.string(), "--threads", "2"}),
              0);
    std::printf("%s", said().c_str());
    return session;
  }
  static Session opened(const fs::path& folder) {
    return Session::open(folder, Session::Access::kRead);
  }

  /// Errors of poses in the map against the truth of a bag.
  static evaluation::PoseErrors errors_of(const std::string& name, const Trajectory& poses) {
    return SimulatedDrives::errors_of(name, poses, T_truth_map(map()));
  }
};

TEST_F(ExtendMap, LeavesTheMapWhereItIsAndItsCloudsOnTheDisk) {
  const Session session = opened(extended());
  const Session old = opened(map());
  const auto change = back_end::change_between(old.poses(), session.poses());
  EXPECT_EQ(change.key_frames, old.key_frame_count());
  EXPECT_LT(change.largest, 0.02);
  EXPECT_EQ(session.datum(), old.datum());
  EXPECT_EQ(session.configurations(), old.configurations());
  EXPECT_TRUE(fs::equivalent(session.clouds().file(0), old.clouds().file(0)));
  EXPECT_FALSE(fs::exists(root() / ".extended.drive.part"));
}

TEST_F(ExtendMap, AddsWhatLiesBeyondAtItsTruePlace) {
  const Session session = opened(extended());
  const Session old = opened(map());
  EXPECT_GT(session.key_frame_count(), old.key_frame_count() + 25);
  const KeyFrameIndex last_of_map = old.key_frames().back().index;
  Trajectory added;
  for (const KeyFramePose& pose : session.poses().poses) {
    if (pose.index <= last_of_map) continue;
    added.poses.push_back({pose.stamp, pose.T_map_base});
    EXPECT_TRUE(session.clouds().contains(pose.index)) << pose.index;
  }
  const auto errors = errors_of("beyond", added);
  EXPECT_EQ(errors.translation_m.count, added.poses.size());
  EXPECT_LT(errors.translation_m.max, 0.15);
  EXPECT_LT(errors.rotation_deg.max, 0.5);
}

TEST_F(ExtendMap, FindsALaterDriveInWhatWasAdded) {
  const std::string later =
      bag("later", {"--pass", "2", "--parked", "2", "--start", "23", "--duration", "31"});
  ASSERT_EQ(localize_in(extended(), later, root() / "later_in_extended"), 0);
  const auto errors =
      errors_of("later", read_trajectory(root() / "later_in_extended/trajectory/localized.tum"));
  EXPECT_GT(errors.translation_m.count, 20U);
  EXPECT_LT(errors.translation_m.max, 0.5);
  EXPECT_LT(errors.translation_m.rmse, 0.15);
}

TEST_F(ExtendMap, GivesTheSameBytesForAnyNumberOfThreads) {
  const fs::path by_one = root() / "extended_by_one";
  ASSERT_EQ(localize_in(map(), beyond(), root() / "beyond_by_one",
                        {"--extend", by_one.string(), "--threads", "1"}),
            0);
  for (const char* file : {"trajectory/optimized.tum", "graph.g2o", "loops.csv"}) {
    const std::string content = content_of(by_one / file);
    EXPECT_GT(content.size(), 500U) << file;
    EXPECT_EQ(content, content_of(extended() / file)) << file;
  }
}

TEST_F(ExtendMap, WritesNothingForADriveThatStaysInTheMap) {
  const fs::path session = root() / "nothing";
  ASSERT_EQ(localize_in(map(), beyond(), root() / "inside",
                        {"--duration", "10", "--extend", session.string()}),
            0);
  EXPECT_TRUE(has_said("so no session is written"));
  EXPECT_FALSE(fs::exists(session));
  EXPECT_FALSE(fs::exists(root() / ".nothing.drive.part"));
}

}  // namespace
}  // namespace lidar_mapping::tools
