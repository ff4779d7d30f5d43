#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/imu_track.hpp"
#include "lidar_mapping/front_end/inertial_sweep.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/preintegration.hpp"

#include "shaken_imu.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr Stamp kFrom = from_seconds(20.0);
constexpr Stamp kTo = from_seconds(20.1);

std::vector<ImuSample> between(const std::vector<ImuSample>& samples, Stamp from, Stamp to) {
  std::vector<ImuSample> result;
  for (const ImuSample& sample : samples) {
    if (sample.stamp >= from && sample.stamp <= to) result.push_back(sample);
  }
  return result;
}

// F: between two instants an IMU follows the exact motion, without knowing where and how fast.
TEST(Preintegration, FollowsTheExactMotion) {
  const auto motion = shaken_motion(4.0);
  ImuKind kind;
  kind.rate = 500.0;
  const Preintegration sum = preintegrated(between(samples_of(motion, kind), kFrom, kTo), {});
  const Pose T_base_imu{Eigen::Quaterniond::Identity(), kind.p_base_imu};
  const auto a = motion.state(kFrom).of_frame(T_base_imu);
  const auto b = motion.state(kTo).of_frame(T_base_imu);
  const Eigen::Vector3d gravity(0.0, 0.0, -9.80665);
  const Eigen::Quaterniond& R = a.T_map_base.rotation;
  const double t = 0.1;
  EXPECT_NEAR(sum.seconds, t, 1e-9);
  EXPECT_LT(rotation_angle((R * sum.rotation).conjugate() * b.T_map_base.rotation), 1e-4);
  EXPECT_LT((a.velocity_map + t * gravity + R * sum.velocity - b.velocity_map).norm(), 1e-3);
  const Eigen::Vector3d p =
      a.T_map_base.translation + t * a.velocity_map + 0.5 * t * t * gravity + R * sum.position;
  EXPECT_LT((p - b.T_map_base.translation).norm(), 1e-4);
}

TEST(Preintegration, KnowsHowBiasesChangeIt) {
  const auto samples = between(samples_of(shaken_motion(4.0), {}), kFrom, kTo);
  const Preintegration sum = preintegrated(samples, {});
  constexpr double kSmall = 1e-5;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d small = kSmall * Eigen::Vector3d::Unit(axis);
    const Preintegration gyro = preintegrated(samples, {small, Eigen::Vector3d::Zero()});
    const Preintegration force = preintegrated(samples, {Eigen::Vector3d::Zero(), small});
    const auto expect = [&](const Eigen::Vector3d& change, const Eigen::Vector3d& derivative) {
      EXPECT_LT((change / kSmall - derivative).norm(), 1e-3 * derivative.norm() + 1e-6) << axis;
    };
    expect(log_so3(sum.rotation.conjugate() * gyro.rotation), sum.rotation_by_gyro.col(axis));
    expect(gyro.velocity - sum.velocity, sum.velocity_by_gyro.col(axis));
    expect(gyro.position - sum.position, sum.position_by_gyro.col(axis));
    expect(force.velocity - sum.velocity, sum.velocity_by_accelerometer.col(axis));
    expect(force.position - sum.position, sum.position_by_accelerometer.col(axis));
  }
}

ImuStretch stretch_of(std::vector<ImuSample> samples) {
  ImuStretch stretch;
  stretch.samples = std::move(samples);
  return stretch;
}

TEST(ImuTrack, KnowsGapsAndEnds) {
  auto samples = between(samples_of(shaken_motion(1.0), {}), 0, from_seconds(2.0));
  samples.erase(samples.begin() + 200, samples.begin() + 220);
  ImuTrack track;
  track.add(stretch_of(samples));
  EXPECT_TRUE(track.covers(from_seconds(0.1), from_seconds(0.9)));
  EXPECT_FALSE(track.covers(from_seconds(0.9), from_seconds(1.2)));
  EXPECT_TRUE(track.covers(from_seconds(1.2), from_seconds(2.0)));
  EXPECT_FALSE(track.covers(from_seconds(1.2), from_seconds(2.1)));
}

TEST(ImuTrack, KnowsASensorThatShowsNoMore) {
  auto samples = between(samples_of(shaken_motion(6.0), {}), 0, from_seconds(10.0));
  for (ImuSample& sample : samples) {
    for (int axis = 0; axis < 3; ++axis) {
      sample.angular_velocity[axis] = std::clamp(sample.angular_velocity[axis], -2.0, 2.0);
    }
  }
  ImuTrack track;
  track.add(stretch_of(samples));
  bool clipped = false, free = false;
  for (Stamp t = from_seconds(1.0); t < from_seconds(9.0); t += from_seconds(0.05)) {
    const bool now = track.is_clipped(t, t + from_seconds(0.05), &ImuSample::angular_velocity);
    clipped = clipped || now;
    free = free || !now;
    EXPECT_FALSE(track.is_clipped(t, t + from_seconds(0.05), &ImuSample::linear_acceleration));
  }
  EXPECT_TRUE(clipped);
  EXPECT_TRUE(free);
}

/// Half a turn a second about an axis that itself moves, and a jolt.
FollowedMotion wild_motion() {
  FollowedMotion motion;
  motion.begin = -0.05;
  motion.step = 0.002;
  for (int k = 0; k <= 50; ++k) {
    const double s = motion.begin + motion.step * k;
    motion.T_reference_base.push_back({exp_so3(Eigen::Vector3d(0.3 * s, 10.0 * s * s, 5.0 * s)),
                                       Eigen::Vector3d(1.5 * s, 15.0 * s * s, 40.0 * s * s * s)});
  }
  return motion;
}

// F: points of a sweep during a quick turn lie where they were seen, in the match and in key
// frames.
TEST(InertialSweep, PutsPointsWhereTheFollowedMotionSays) {
  const FollowedMotion motion = wild_motion();
  Vector6d twist;
  twist << 1.4, 0.1, 0.0, 0.2, -0.1, 4.8;
  const double reference = 0.05;
  const InertialSweep sweep(motion, twist, reference);
  PointCloud cloud;
  SampledPoints points;
  const Eigen::Vector3d there(12.0, -7.0, 1.5);  // seen all the time, at the reference time
  for (int k = 0; k <= 50; k += 5) {
    const Eigen::Vector3f seen =
        (motion.T_reference_base[static_cast<std::size_t>(k)].inverse() * there).cast<float>();
    const float s = static_cast<float>(motion.begin + motion.step * k);
    points.x.push_back(seen.x());
    points.y.push_back(seen.y());
    points.z.push_back(seen.z());
    points.s.push_back(s);
    cloud.points.push_back({seen.x(), seen.y(), seen.z(), 1.0F});
    cloud.times.push_back(s + static_cast<float>(reference));
  }
  sweep.bend(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p(points.x[i], points.y[i], points.z[i]);
    const double s = points.s[i];
    const Eigen::Vector3d speed = twist.head<3>() + twist.tail<3>().cross(p);
    const Eigen::Vector3d placed = p + s * speed + 0.5 * s * s * twist.tail<3>().cross(speed);
    EXPECT_LT((placed - there).norm(), 1e-4) << s;
  }
  const Eigen::Vector3d at_stamp = motion.at(-reference).inverse() * there;
  const PointCloud still = sweep.deskewed(cloud, 1);
  EXPECT_FALSE(still.has_times());
  for (const Point& p : still.points) {
    EXPECT_LT((Eigen::Vector3d(p.x, p.y, p.z) - at_stamp).norm(), 1e-3);
  }
  EXPECT_LT(difference(sweep.T_reference_stamp(), motion.at(-reference)).norm(), 1e-9);
}

// What the match corrects is a constant twist on top of the motion.
TEST(InertialSweep, TakesTheMatchedTwistForACorrection) {
  const FollowedMotion motion = wild_motion();
  Vector6d twist = Vector6d::Zero();
  twist[5] = 5.0;
  InertialSweep sweep(motion, twist, 0.05);
  Vector6d matched = twist;
  matched[0] += 0.2;
  sweep.set_matched(matched);
  const Eigen::Vector3d way = sweep.T_reference_stamp().translation - motion.at(-0.05).translation;
  EXPECT_NEAR(way.norm(), 0.2 * 0.05, 2e-3);
}

}  // namespace
}  // namespace lidar_mapping::front_end
