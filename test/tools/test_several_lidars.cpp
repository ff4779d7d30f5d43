// SPDX-License-Identifier: BSD-3-Clause
// A vehicle with two LiDARs: what they measure together has to give the poses of a single one that
// measures the same.
#include <cmath>

#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"

#include "input_forms.hpp"

namespace lidar_mapping::tools {
namespace {

using sensor_msgs::PointCloud2;
using test::kTopic;
using test::TimedPoint;

constexpr char kSecond[] = "/second";

/// Divides the points of a LiDAR among two: every second point is one of a LiDAR that is mounted
/// elsewhere and begins its turns at another time.
class SeveralLidars : public test::InputForms {
 protected:
  struct Second {
    bool is_recorded = true;
    bool has_transform = true;
    bool has_times = true;
    double phase = 0.037;  ///< s
  };

  /// One LiDAR whose points come in the order in which those of two are merged.
  std::string bag_in_order_of_lidars() const {
    return written("whole", test::with([](const PointCloud2& cloud) {
                     std::vector<TimedPoint> first, second;
                     std::size_t index = 0;
                     for (const TimedPoint& point : test::points_of(cloud)) {
                       (index++ % 2 == 0 ? first : second).push_back(point);
                     }
                     first.insert(first.end(), second.begin(), second.end());
                     return test::plain_cloud(cloud.header, first);
                   }));
  }

  static Pose T_first_second() {
    Pose T;
    T.rotation = exp_so3({0.3, -0.2, 1.5});
    T.translation = {-1.5, 0.4, -0.6};
    return T;
  }

  std::string divided(const std::string& name, const Second& second) const {
    std::vector<AbsolutePoint> points;  // of the second LiDAR
    std::int64_t turn_end = 0;
    const auto write = [&](rosbag::Bag& to, const rosbag::MessageInstance& m) {
      if (const auto frames = m.instantiate<tf2_msgs::TFMessage>()) {
        to.write(m.getTopic(), m.getTime(), second.has_transform ? with_second(*frames) : *frames);
        return true;
      }
      const auto cloud = m.instantiate<PointCloud2>();
      if (!cloud) return false;
      const auto begin = static_cast<std::int64_t>(cloud->header.stamp.toNSec());
      if (turn_end == 0) turn_end = begin + std::llround(1e9 * second.phase);
      std::vector<TimedPoint> first;
      std::size_t index = 0;
      for (const TimedPoint& point : test::points_of(*cloud)) {
        if (index++ % 2 == 0) {
          first.push_back(point);
        } else {
          points.push_back({begin + std::llround(1e9 * static_cast<double>(point.time)), point});
        }
      }
      while (second.is_recorded && turn_end < begin + 100'000'000) {
        write_turn(to, points, turn_end, second);
        turn_end += 100'000'000;
      }
      to.write(kTopic, m.getTime(), test::plain_cloud(cloud->header, first));
      return true;
    };
    return rewritten(name, write);
  }
  std::string divided(const std::string& name) const { return divided(name, {}); }

 private:
  struct AbsolutePoint {
    std::int64_t time;  ///< ns
    TimedPoint point;
  };

  static tf2_msgs::TFMessage with_second(tf2_msgs::TFMessage message) {
    for (std::size_t i = message.transforms.size(); i-- > 0;) {
      geometry_msgs::TransformStamped transform = message.transforms[i];
      if (transform.child_frame_id != "velo_link") continue;
      transform.header.frame_id = "velo_link";
      transform.child_frame_id = "second_link";
      transform.transform = ros_border::to_transform(T_first_second());
      message.transforms.push_back(transform);
    }
    return message;
  }

  /// The points before `end`, stamped there, as some drivers do.
  static void write_turn(rosbag::Bag& to, std::vector<AbsolutePoint>& points, std::int64_t end,
                         const Second& second) {
    std_msgs::Header header;
    header.stamp.fromNSec(static_cast<std::uint64_t>(end));
    header.frame_id = "second_link";
    const Pose T_second_first = T_first_second().inverse();
    std::vector<TimedPoint> turn;
    std::vector<AbsolutePoint> rest;
    for (const AbsolutePoint& absolute : points) {
      if (absolute.time >= end) {
        rest.push_back(absolute);
        continue;
      }
      TimedPoint point = absolute.point;
      const Eigen::Vector3d p = T_second_first * Eigen::Vector3d(point.x, point.y, point.z);
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.time = static_cast<float>(1e-9 * static_cast<double>(absolute.time - end));
      turn.push_back(point);
    }
    points = rest;
    PointCloud2 cloud = test::plain_cloud(header, turn);
    if (!second.has_times) cloud.fields.back().name = "ring";
    to.write(kSecond, header.stamp, cloud);
  }
};

TEST_F(SeveralLidars, TwoThatMeasureTogetherGiveThePosesOfOne) {
  // Without the end, in which the second LiDAR's last turn is cut.
  const std::string seconds = "7";
  const Trajectory whole = mapped(bag_in_order_of_lidars(), {"--duration", seconds});
  const test::Words merged = {"--duration", seconds, "--points", "/points,/second"};
  expect_equal_poses(mapped(divided("two"), merged), whole);
  // Another phase, in which the turns of the two begin together.
  Second second;
  second.phase = 0.1;
  expect_equal_poses(mapped(divided("together", second), merged), whole);
}

TEST_F(SeveralLidars, WithoutRequestTheOtherIsNamed) {
  checked(divided("two"));
  EXPECT_TRUE(has_said("; other clouds: /second"));
}

/// Drives with a second LiDAR that cannot be used: map_bag says why, and the first is mapped alone.
class UnusableSecondLidar : public SeveralLidars {
 protected:
  void expect_left_out(const Second& second, const std::string& reason) const {
    const std::string alone = divided("alone", [] {
      Second none;
      none.is_recorded = false;
      return none;
    }());
    const Trajectory poses = mapped(divided("unusable", second), {"--points", "/points,/second"});
    EXPECT_TRUE(has_said("the clouds of /second are left out: " + reason));
    expect_equal_poses(poses, mapped(alone));
  }
};

TEST_F(UnusableSecondLidar, WithoutTransformIsNamed) {
  Second second;
  second.has_transform = false;
  expect_left_out(second, "no transform leads from 'second_link'");
}

TEST_F(UnusableSecondLidar, WithoutTimesIsNamed) {
  Second second;
  second.has_times = false;
  expect_left_out(second, "their points have no times");
}

TEST_F(SeveralLidars, OneThatIsNamedTwiceIsRefused) {
  expect_said(checked(divided("twice"), {"--points", "/points,/points"}),
              "--points names /points twice", 2);
}

TEST_F(SeveralLidars, OneThatIsNotRecordedIsNamed) {
  Second second;
  second.is_recorded = false;
  const std::string bag = divided("one", second);
  expect_said(checked(bag, {"--points", "/points,/second"}), "there is no topic /second of type",
              2);
}

TEST_F(SeveralLidars, OneThatEndsEarlyIsNamedAndDelaysNothing) {
  const std::string both = divided("both");
  const std::string cut = folder_.path() / "cut.bag";
  std::size_t turns = 0;
  test::rewrite_bag(both, cut, [&](rosbag::Bag&, const rosbag::MessageInstance& m) {
    return m.getTopic() == kSecond && ++turns > 40;  // not written
  });
  const Trajectory poses = mapped(cut, {"--points", "/points,/second"});
  EXPECT_TRUE(has_said(" scans have no points of /second: it has no clouds at their time"));
  EXPECT_EQ(poses.poses.size(), mapped(both).poses.size());
}

/// Root mean square of the distances from the truth, both counted from the first pose, m.
double error_of(const Trajectory& trajectory, const Trajectory& truth) {
  EXPECT_EQ(trajectory.poses.size(), truth.poses.size());
  const Pose T_truth = truth.poses.front().pose, T_own = trajectory.poses.front().pose;
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    EXPECT_EQ(trajectory.poses[i].stamp, truth.poses[i].stamp);
    const Pose expected = T_truth.inverse() * truth.poses[i].pose;
    const Pose found = T_own.inverse() * trajectory.poses[i].pose;
    sum += (found.translation - expected.translation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.poses.size()));
}

TEST_F(SeveralLidars, ASecondLidarMakesTheOdometryMoreExact) {
  const std::string bag = folder_.path() / "rear.bag", truth_file = folder_.path() / "truth.tum";
  ASSERT_EQ(
      run("simulate_drive", {bag, "--lidar", "vlp16", "--second-lidar", "vlp16", "--duration", "15",
                             "--no-imu", "--no-velocity", "--no-gnss", "--truth", truth_file}),
      0);
  const Trajectory truth = read_trajectory(truth_file);
  const double alone = error_of(mapped(bag, {"--points", "/kitti/velo/pointcloud"}), truth);
  const double merged =
      error_of(mapped(bag, {"--points", "/kitti/velo/pointcloud,/second/points"}), truth);
  std::printf("error: %.1f mm alone, %.1f mm with the second LiDAR\n", 1e3 * alone, 1e3 * merged);
  EXPECT_LT(merged, alone);
  EXPECT_GT(alone, 0.0);
}

}  // namespace
}  // namespace lidar_mapping::tools
