// SPDX-License-Identifier: BSD-3-Clause
// Poses of scans between key frames. What is made of them is tested in test_scan_clouds.cpp.
#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/scan_track.hpp"

#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

constexpr Stamp kBegin = 1'700'000'000'000'000'000;

Stamp stamp_at(double seconds) { return kBegin + from_seconds(seconds); }

Pose pose_at(double x, double yaw = 0.0) { return {exp_so3({0.0, 0.0, yaw}), {x, 0.0, 0.0}}; }

/// A session with scans and key frames whose odometry drives along x at 10 m/s.
class ScanTrack : public testing::Test {
 protected:
  void add_scan(double seconds, const std::string& state = "tracking", double shift = 0.0) {
    session::ScanRecord scan;
    scan.stamp = stamp_at(seconds);
    scan.state = state;
    scan.elevation_shift = shift;
    session_.add_scan(scan);
    session_.add_odometry(scan.stamp, pose_at(10.0 * seconds));
  }
  /// A key frame that lies this far to the left in the map.
  void add_key_frame(double seconds, double left, std::uint32_t segment = 0) {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(poses_.poses.size());
    key_frame.segment = segment;
    key_frame.stamp = stamp_at(seconds);
    key_frame.T_odom_base = pose_at(10.0 * seconds);
    key_frame.cloud = std::make_shared<PointCloud>();
    session_.add_key_frame(key_frame);
    Pose moved = key_frame.T_odom_base;
    moved.translation.y() += left;
    poses_.poses.push_back({key_frame.index, key_frame.stamp, moved});
  }
  std::vector<double> lefts() const {
    std::vector<double> result;
    for (const ScanPose& scan : scan_poses(session_, poses_)) {
      result.push_back(scan.T_map_base.translation.y());
    }
    return result;
  }
  std::vector<Stamp> stamps() const {
    std::vector<Stamp> result;
    for (const ScanPose& scan : scan_poses(session_, poses_)) result.push_back(scan.stamp);
    return result;
  }

  test::TemporaryFolder folder_;
  session::Session session_ = session::Session::create_in(folder_.path() / "drive");
  KeyFramePoses poses_;
};

TEST_F(ScanTrack, IsEmptyWithoutScansOrKeyFrames) {
  EXPECT_TRUE(scan_poses(session_, poses_).empty());
  add_scan(0.0);
  EXPECT_TRUE(scan_poses(session_, poses_).empty()) << "nothing says where the map is";
}

// The nearer key frame has more weight; before the first and behind the last there is one.
TEST_F(ScanTrack, IsCorrectedByTheTimeToTheKeyFrames) {
  for (int i = 0; i <= 8; ++i) add_scan(0.1 * i);
  add_key_frame(0.2, 1.0);
  add_key_frame(0.6, 3.0);
  const std::vector<double> expected = {1.0, 1.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0};
  const std::vector<double> found = lefts();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
}

TEST_F(ScanTrack, LeavesOutLostAndRepeatedScans) {
  add_scan(0.0);
  add_scan(0.1, "lost");
  add_scan(0.2, "degenerate");
  add_scan(0.3, "repeated");
  add_scan(0.4, "doubtful");
  add_key_frame(0.0, 0.0);
  EXPECT_EQ(stamps(), (std::vector<Stamp>{stamp_at(0.0), stamp_at(0.2), stamp_at(0.4)}));
}

// How the two segments lie to each other was not observed.
TEST_F(ScanTrack, LeavesOutScansBetweenSegments) {
  for (int i = 0; i <= 5; ++i) add_scan(0.1 * i);
  add_key_frame(0.1, 1.0, 0);
  add_key_frame(0.4, 100.0, 1);
  EXPECT_EQ(stamps(),
            (std::vector<Stamp>{stamp_at(0.0), stamp_at(0.1), stamp_at(0.4), stamp_at(0.5)}));
  const std::vector<double> found = lefts();
  EXPECT_NEAR(found[1], 1.0, 1e-6);
  EXPECT_NEAR(found[2], 100.0, 1e-6);
}

// A session of two drives whose first one was recorded later.
TEST_F(ScanTrack, KnowsDrivesThatWereMergedInReverse) {
  for (int i = 0; i <= 5; ++i) add_scan(0.1 * i);
  add_key_frame(0.4, 100.0, 0);
  add_key_frame(0.1, 1.0, 1);
  EXPECT_EQ(stamps(),
            (std::vector<Stamp>{stamp_at(0.0), stamp_at(0.1), stamp_at(0.4), stamp_at(0.5)}));
  const std::vector<double> found = lefts();
  EXPECT_NEAR(found[1], 1.0, 1e-6);
  EXPECT_NEAR(found[2], 100.0, 1e-6);
}

TEST_F(ScanTrack, DoesWithoutKeyFramesThatHaveNoPose) {
  for (int i = 0; i <= 4; ++i) add_scan(0.1 * i);
  add_key_frame(0.0, 0.0);
  add_key_frame(0.2, 50.0);
  add_key_frame(0.4, 4.0);
  poses_.poses.erase(poses_.poses.begin() + 1);
  const std::vector<double> found = lefts();
  ASSERT_EQ(found.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(found[i], static_cast<double>(i), 1e-6) << "on the way to the next that has one";
  }
}

// As in the map up to a date: the scans behind the last pose are those of later days.
TEST_F(ScanTrack, EndsWhereThePosesEndBeforeTheKeyFrames) {
  for (int i = 0; i <= 6; ++i) add_scan(0.1 * i);
  for (const double seconds : {0.1, 0.3, 0.5}) add_key_frame(seconds, 1.0);
  const KeyFramePoses whole = poses_;
  poses_.poses.pop_back();
  EXPECT_EQ(stamps(),
            (std::vector<Stamp>{stamp_at(0.0), stamp_at(0.1), stamp_at(0.2), stamp_at(0.3)}));
  poses_.poses = {whole.poses.begin() + 1, whole.poses.end()};
  EXPECT_EQ(stamps(),
            (std::vector<Stamp>{stamp_at(0.3), stamp_at(0.4), stamp_at(0.5), stamp_at(0.6)}));
}

TEST_F(ScanTrack, DerivesTheMotionFromTheNeighbours) {
  for (int i = 0; i <= 4; ++i) add_scan(0.1 * i);
  add_key_frame(0.0, 0.0);
  for (const ScanPose& scan : scan_poses(session_, poses_)) {
    Vector6d expected = Vector6d::Zero();
    expected[0] = 10.0;
    EXPECT_TRUE(test::near(scan.twist, expected, 1e-6)) << to_seconds(scan.stamp - kBegin);
    EXPECT_TRUE(test::near(scan.acceleration, Vector6d::Zero().eval(), 1e-4));
  }
}

// Over a gap of more than half a second the vehicle may have done anything.
TEST_F(ScanTrack, GivesNoMotionOverAGap) {
  add_scan(0.0);
  add_scan(0.6);
  add_scan(0.7);
  add_key_frame(0.0, 0.0);
  const std::vector<ScanPose> scans = scan_poses(session_, poses_);
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_TRUE(scans[0].twist.isZero(0.0));
  EXPECT_NEAR(scans[1].twist[0], 10.0, 1e-6) << "by the scan after it alone";
  EXPECT_TRUE(scans[1].acceleration.isZero(0.0));
  EXPECT_NEAR(scans[2].twist[0], 10.0, 1e-6);
}

/// A drive along x that was merged with others, for which it lies beside their place.
struct MergedDrive {
  std::uint32_t number;
  double delay;  ///< s
  double aside;  ///< m

  void write(session::Session& session, KeyFramePoses& poses) const {
    for (int i = 0; i <= 8; ++i) {
      session::ScanRecord scan;
      scan.stamp = stamp_at(delay + 0.1 * i);
      scan.state = "tracking";
      session.add_scan(scan);
      Pose T_odom_base = pose_at(i, 0.01 * i);
      T_odom_base.translation.y() = aside;
      session.add_odometry({scan.stamp, T_odom_base, number});
      if (i % 3 != 1) continue;
      KeyFrame key_frame;
      key_frame.index = static_cast<KeyFrameIndex>(poses.poses.size());
      key_frame.segment = number;
      key_frame.stamp = scan.stamp;
      key_frame.T_odom_base = T_odom_base;
      key_frame.cloud = std::make_shared<PointCloud>();
      session.add_key_frame(key_frame);
      T_odom_base.translation.z() += 0.1 * i;
      poses.poses.push_back({key_frame.index, key_frame.stamp, T_odom_base});
    }
  }
};

std::vector<ScanPose> scan_poses_of(const std::vector<MergedDrive>& drives) {
  const test::TemporaryFolder folder;
  session::Session session = session::Session::create_in(folder.path() / "drive");
  KeyFramePoses poses;
  for (const MergedDrive& drive : drives) drive.write(session, poses);
  return scan_poses(session, poses);
}

TEST(ScanTrackOfDrives, IsThatOfEachAloneWhereTheyOverlapInTime) {
  const MergedDrive one{0, 0.0, 0.0};
  const MergedDrive other{1, 0.05, 500.0};
  const std::vector<ScanPose> both = scan_poses_of({one, other});
  std::vector<ScanPose> expected = scan_poses_of({one});
  const std::vector<ScanPose> of_other = scan_poses_of({other});
  expected.insert(expected.end(), of_other.begin(), of_other.end());
  std::sort(expected.begin(), expected.end(),
            [](const ScanPose& a, const ScanPose& b) { return a.stamp < b.stamp; });
  ASSERT_EQ(expected.size(), 18U);
  ASSERT_EQ(both.size(), expected.size());
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_EQ(both[i].stamp, expected[i].stamp);
    EXPECT_EQ(both[i].T_map_base.translation, expected[i].T_map_base.translation) << i;
    EXPECT_EQ(both[i].twist, expected[i].twist) << i;
    EXPECT_EQ(both[i].acceleration, expected[i].acceleration) << i;
  }
}

TEST_F(ScanTrack, HasTheElevationShiftOfEachScan) {
  add_scan(0.0, "tracking", 0.0);
  add_scan(0.1, "tracking", 0.004);
  add_key_frame(0.0, 0.0);
  const std::vector<ScanPose> scans = scan_poses(session_, poses_);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].elevation_shift, 0.0);
  EXPECT_EQ(scans[1].elevation_shift, 0.004);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
