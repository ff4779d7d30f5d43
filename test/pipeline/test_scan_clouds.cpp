// SPDX-License-Identifier: BSD-3-Clause
// All scans of a drive can be added to the map, each at its pose and deskewed.
#include <gtest/gtest.h>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/scan_clouds.hpp"

#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

constexpr Stamp kBegin = 1'700'000'000'000'000'000;
constexpr double kPeriod = 0.1;  // s
constexpr int kScans = 41;
constexpr int kPerKeyFrame = 8;

/// A drive on a circle with increasing speed.
Pose truth(double t) {
  const double distance = 8.0 * t + 0.5 * t * t;
  const double radius = 20.0;
  return {
      exp_so3({0.0, 0.0, distance / radius}),
      {radius * std::sin(distance / radius), radius * (1.0 - std::cos(distance / radius)), 0.0}};
}

Stamp stamp_of(int scan) { return kBegin + from_seconds(kPeriod * scan); }

/// Odometry with constant drift.
Pose odometry(double t) {
  return Pose{exp_so3({0.0, 0.0, 0.002 * t}), {0.03 * t, -0.02 * t, 0.01 * t}} * truth(t);
}

/// A scan of static posts taken in motion, with a sensor whose elevations are too low by an angle.
PointCloud scan_at(double t, double elevation_error) {
  const ElevationShift downwards(-elevation_error);
  PointCloud cloud;
  for (int i = 0; i < 360; ++i) {
    const double late = kPeriod * i / 360.0;
    const Eigen::Vector3d post(12.0 + 4.0 * (i % 5), 25.0 - 6.0 * (i % 7), 1.0 + 0.1 * (i % 3));
    Eigen::Vector3f p = (truth(t + late).inverse() * post).cast<float>();
    downwards(p.x(), p.y(), p.z());
    cloud.points.push_back({p.x(), p.y(), p.z(), static_cast<float>(i)});
    cloud.times.push_back(static_cast<float>(late));
  }
  return cloud;
}

Eigen::Vector3d post_of(const Point& point) {
  const int i = static_cast<int>(point.intensity);
  return {12.0 + 4.0 * (i % 5), 25.0 - 6.0 * (i % 7), 1.0 + 0.1 * (i % 3)};
}

class Recording : public InputSource {
 public:
  explicit Recording(Stamp shift = 0, double elevation_error = 0.0)
      : shift_(shift), elevation_error_(elevation_error) {}
  std::optional<Input> next() override {
    if (next_ == kScans) return std::nullopt;
    const int scan = next_++;
    const Stamp stamp = stamp_of(scan) + shift_;
    return RecordedScan{
        stamp, [stamp, scan, elevation_error = elevation_error_](const PointCloud& /*buffer*/) {
          return preprocessing::RawScan{stamp, "lidar", scan_at(kPeriod * scan, elevation_error),
                                        true};
        }};
  }
  void skip_to(Stamp /*stamp*/) override {}
  Stamp begin() const override { return stamp_of(0); }
  Stamp end() const override { return stamp_of(kScans - 1); }
  std::optional<Pose> T_base(const std::string& /*frame_id*/) const override { return Pose(); }

 private:
  Stamp shift_;
  double elevation_error_;
  int next_ = 0;
};

class DenseMap : public testing::Test {
 protected:
  DenseMap() : session_(session::Session::create_in(folder_.path() / "session")) {
    for (int i = 0; i < kScans; ++i) {
      const Pose T_odom_base = odometry(kPeriod * i);
      session_.add_odometry(stamp_of(i), T_odom_base);
      session_.add_scan(
          {stamp_of(i), i == kLost ? "lost" : "tracking", 0.0, 0.0, 0.0, 0, 0.0, 0.0, {}});
      if (i % kPerKeyFrame != 0) continue;
      KeyFrame key_frame;
      key_frame.index = static_cast<KeyFrameIndex>(poses_.poses.size());
      key_frame.segment = i > kBreak ? 1 : 0;
      key_frame.stamp = stamp_of(i);
      key_frame.T_odom_base = T_odom_base;
      session_.add_key_frame(key_frame);
      poses_.poses.push_back({key_frame.index, key_frame.stamp, truth(kPeriod * i)});
    }
  }

  KeyFramePoses add_all(const ScanSelection& selection, ScanClouds& clouds) {
    Recording recording;
    return add_scans(recording, scan_poses(session_, poses_), {}, selection, clouds);
  }

  static constexpr int kLost = 5;
  static constexpr int kBreak = 20;  // the key frames before and after are of two segments

  test::TemporaryFolder folder_;
  session::Session session_;
  KeyFramePoses poses_;
};

TEST_F(DenseMap, ComputesPoseOfEachScan) {
  const auto scans = scan_poses(session_, poses_);
  // Without the lost scan, and those between the key frames 16 and 24.
  ASSERT_EQ(scans.size(), static_cast<std::size_t>(kScans - 1 - 7));
  for (const ScanPose& scan : scans) {
    const double t = to_seconds(scan.stamp - kBegin);
    EXPECT_TRUE(test::near(scan.T_map_base, truth(t), 0.002)) << t;
    const double speed = 8.0 + t;
    EXPECT_NEAR(scan.twist[0], speed, 0.1) << t;
    EXPECT_NEAR(scan.twist[5], speed / 20.0, 0.01) << t;
  }
}

TEST_F(DenseMap, PlacesPointsCorrectly) {
  ScanClouds clouds(folder_.path());
  const KeyFramePoses poses = add_all({}, clouds);
  ASSERT_EQ(poses.poses.size(), static_cast<std::size_t>(kScans - 1 - 7));
  for (const KeyFramePose& pose : poses.poses) {
    const PointCloudPtr cloud = clouds.cloud(pose.index);
    ASSERT_EQ(cloud->size(), 360U);
    for (const Point& point : cloud->points) {
      const Eigen::Vector3d p_map = pose.T_map_base * point.position().cast<double>();
      ASSERT_TRUE(test::near(p_map, post_of(point), 0.02)) << pose.stamp - kBegin;
    }
  }
  EXPECT_EQ(clouds.clouds({3, 99}, 2).front()->size(), 360U);
  EXPECT_EQ(clouds.clouds({3, 99}, 2).back(), nullptr);
}

/// The clouds of key frames are already corrected.
TEST_F(DenseMap, CorrectsElevationsLikeFrontEnd) {
  constexpr double kElevationError = 0.02;  // rad
  session::Session session = session::Session::create_in(folder_.path() / "leaning");
  for (int i = 0; i < kScans; ++i) {
    session::ScanRecord record;
    record.stamp = stamp_of(i);
    record.state = "tracking";
    record.elevation_shift = kElevationError;
    session.add_scan(record);
    session.add_odometry(record.stamp, truth(kPeriod * i));
  }
  KeyFrame first;
  first.stamp = stamp_of(0);
  session.add_key_frame(first);
  KeyFramePoses poses;
  poses.poses.push_back({0, first.stamp, Pose()});
  Recording recording(0, kElevationError);
  ScanClouds clouds(folder_.path());
  const KeyFramePoses add_all = add_scans(recording, scan_poses(session, poses), {}, {}, clouds);
  ASSERT_EQ(add_all.poses.size(), static_cast<std::size_t>(kScans));
  for (const KeyFramePose& pose : add_all.poses) {
    const PointCloudPtr cloud = clouds.cloud(pose.index);
    for (const Point& point : cloud->points) {
      const Eigen::Vector3d p_map = pose.T_map_base * point.position().cast<double>();
      ASSERT_TRUE(test::near(p_map, post_of(point), 0.05)) << pose.stamp - kBegin;
    }
  }
}

TEST_F(DenseMap, SelectsScansAndResolution) {
  ScanClouds clouds(folder_.path());
  ScanSelection selection;
  selection.every = 4;
  selection.resolution = 1.0;
  const KeyFramePoses poses = add_all(selection, clouds);
  EXPECT_EQ(poses.poses.size(), 9U);
  EXPECT_LT(clouds.cloud(0)->size(), 100U) << "105 posts, some of them in one voxel";
}

TEST_F(DenseMap, RejectsAnotherRecording) {
  Recording other(from_seconds(0.05));
  ScanClouds clouds(folder_.path());
  EXPECT_THROW(add_scans(other, scan_poses(session_, poses_), {}, {}, clouds), InputError);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
