// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gnss/local_frame.hpp"
#include "motion/interpolation.hpp"
#include "motion/sample_buffer.hpp"
#include "motion/sensor_stream.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using lidar_mapping::test::near;
using test::at;

TEST(SampleBuffer, SortsSamplesByTheirStamps) {
  std::mt19937 engine(1);
  std::vector<int> order(100);
  for (int i = 0; i < 100; ++i) order[i] = i;
  for (std::size_t i = 0; i + 5 < order.size(); i += 5) {
    std::shuffle(order.begin() + static_cast<long>(i), order.begin() + static_cast<long>(i) + 5,
                 engine);
  }
  SampleBuffer<ImuSample> buffer(from_seconds(10.0), 1000);
  for (const int i : order) EXPECT_TRUE(buffer.insert(test::imu(at(0.01 * i))));
  for (int i = 0; i + 1 < 100; ++i) {
    const auto pair = buffer.around(at(0.01 * i + 0.005), from_seconds(0.02));
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->first->stamp, at(0.01 * i));
    EXPECT_EQ(pair->second->stamp, at(0.01 * (i + 1)));
  }
}

TEST(SampleBuffer, RejectsDuplicatesAndStaysBounded) {
  SampleBuffer<ImuSample> buffer(from_seconds(1.0), 50);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_TRUE(buffer.insert(test::imu(at(0.01 * i))));
    EXPECT_FALSE(buffer.insert(test::imu(at(0.01 * i))));
    EXPECT_LE(buffer.size(), 50U);
  }
  EXPECT_FALSE(buffer.insert(test::imu(at(0.0))));
}

TEST(Interpolation, StaysBetweenNeighboursOrIsEmpty) {
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> value(-5.0, 5.0);
  std::uniform_real_distribution<double> step(0.001, 0.4);
  const Stamp gap = from_seconds(0.2);
  SampleBuffer<VelocitySample> buffer(from_seconds(1000.0), 100000);
  double end = 0.0;
  for (int i = 0; i < 2000; ++i) {
    end += step(engine);
    buffer.insert(test::velocity(at(end), {value(engine), 0.0, 0.0}));
  }
  std::uniform_real_distribution<double> when(-1.0, end + 1.0);
  int found = 0;
  for (int i = 0; i < 5000; ++i) {
    const Stamp stamp = at(when(engine));
    const auto pair = buffer.around(stamp, gap);
    if (!pair) continue;
    ++found;
    ASSERT_LE(pair->first->stamp, stamp);
    ASSERT_GE(pair->second->stamp, stamp);
    ASSERT_LE(pair->second->stamp - pair->first->stamp, gap);
    const double x = interpolated(*pair->first, *pair->second, stamp).linear.x();
    EXPECT_GE(x, std::min(pair->first->linear.x(), pair->second->linear.x()) - 1e-12);
    EXPECT_LE(x, std::max(pair->first->linear.x(), pair->second->linear.x()) + 1e-12);
  }
  EXPECT_GT(found, 500);
  EXPECT_LT(found, 4500);
}

TEST(Interpolation, UsesTheShorterRotationForAnySigns) {
  for (double yaw = -3.1; yaw < 3.1; yaw += 0.1) {
    ImuSample a = test::imu(at(0.0));
    ImuSample b = test::imu(at(0.1));
    a.orientation = exp_so3({0.0, 0.0, yaw});
    b.orientation = exp_so3({0.0, 0.0, yaw + 0.1});
    b.orientation->coeffs() *= -1.0;
    const auto middle = interpolated(a, b, at(0.05)).orientation;
    ASSERT_TRUE(middle);
    EXPECT_LT(rotation_angle(*middle * exp_so3({0.0, 0.0, -(yaw + 0.05)})), 1e-7);
  }
}

TEST(Interpolation, HasNoOrientationIfOneSampleHasNone) {
  ImuSample with = test::imu(at(0.0));
  with.orientation = Eigen::Quaterniond::Identity();
  const ImuSample without = test::imu(at(0.1));
  ASSERT_FALSE(without.orientation);
  EXPECT_FALSE(interpolated(with, without, at(0.05)).orientation);
  EXPECT_FALSE(interpolated(without, with, at(0.05)).orientation);
}

TEST(Interpolation, TransfersVelocitiesOfRotatedAndDistantSensors) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto vector = [&] {
    return Eigen::Vector3d(normal(engine), normal(engine), normal(engine));
  };
  for (int i = 0; i < 100; ++i) {
    const Pose T_base_sensor{exp_so3(vector()), vector()};
    const Eigen::Vector3d v = vector(), omega = vector();
    // The sensor's place in the world by the motion of base_link, half a step each way.
    const double h = 1e-6;
    const auto sensor_at = [&](double t) {
      return Pose{exp_so3(omega * t), v * t} * T_base_sensor;
    };
    const Eigen::Vector3d v_world =
        (sensor_at(h).translation - sensor_at(-h).translation) / (2 * h);
    const VelocitySample measured{at(0.0), T_base_sensor.rotation.conjugate() * v_world,
                                  T_base_sensor.rotation.conjugate() * omega};
    const VelocitySample base = in_base(measured, T_base_sensor);
    EXPECT_TRUE(near(base.linear, v, 1e-8));
    EXPECT_TRUE(near(base.angular, omega, 1e-12));
  }
}

TEST(Interpolation, ComposesTheOrientationOnTheRightSide) {
  // An IMU mounted with 90 degrees of yaw on a vehicle that heads for 30 degrees.
  const Pose T_base_imu{exp_so3({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.0}};
  ImuSample sample = test::imu(at(0.0), {1.0, 0.0, 0.0});
  sample.orientation = exp_so3({0.0, 0.0, M_PI / 6.0}) * T_base_imu.rotation;
  const ImuSample base = in_base(sample, T_base_imu);
  EXPECT_NEAR(yaw_of(*base.orientation), M_PI / 6.0, 1e-12);
  EXPECT_TRUE(near(base.angular_velocity, Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Interpolation, KeepsFixesOnTheTrack) {  // 30 m/s, 10 Hz and 1 Hz
  for (const double period : {0.1, 1.0}) {
    const LocalFix a{at(0.0), {0.0, 0.0, 0.0}, 0.01 * Eigen::Matrix3d::Identity()};
    const LocalFix b{at(period), {30.0 * period, 0.0, 0.0}, 0.01 * Eigen::Matrix3d::Identity()};
    const LocalFix middle = interpolated(a, b, at(0.3 * period));
    EXPECT_NEAR(middle.p_enu.x(), 9.0 * period, 1e-6);
    EXPECT_GE(middle.covariance(0, 0), 0.01);
    // What the vehicle may have done between the fixes is in the covariance.
    EXPECT_NEAR(middle.covariance(0, 0), 0.01 + std::pow(0.21 * period * period, 2), 1e-9);
  }
}

LocalFix on_circle(double seconds, double radius, double speed) {
  const double angle = seconds * speed / radius;
  return {at(seconds), radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0),
          1e-4 * Eigen::Matrix3d::Identity()};
}

TEST(Interpolation, FollowsABendBetweenFixes) {
  const double radius = 15.0, speed = 7.0;  // 3.3 m/s^2
  const auto error = [&](const LocalFix& fix, double seconds) {
    return (fix.p_enu - on_circle(seconds, radius, speed).p_enu).norm();
  };
  for (const double period : {0.1, 1.0}) {
    const LocalFix earlier = on_circle(-period, radius, speed), a = on_circle(0.0, radius, speed),
                   b = on_circle(period, radius, speed);
    for (const double share : {0.1, 0.5, 0.9}) {
      const double seconds = share * period;
      const LocalFix chord = interpolated(a, b, at(seconds));
      const LocalFix bend = interpolated(earlier, a, b, at(seconds));
      EXPECT_LT(error(bend, seconds), 0.35 * error(chord, seconds));
      EXPECT_LT(error(bend, seconds), 2.0 * std::sqrt(bend.covariance(0, 0)));
    }
  }
}

TEST(Interpolation, IsLinearIfThePreviousFixIsTooNear) {
  const LocalFix earlier = on_circle(-0.01, 15.0, 7.0), a = on_circle(0.0, 15.0, 7.0),
                 b = on_circle(0.1, 15.0, 7.0);
  EXPECT_EQ(interpolated(earlier, a, b, at(0.05)).p_enu, interpolated(a, b, at(0.05)).p_enu);
}

TEST(SampleBuffer, FindsThePreviousSample) {
  SampleBuffer<LocalFix> buffer(from_seconds(100.0), 10);
  for (const double seconds : {1.0, 2.0, 5.0}) buffer.insert(on_circle(seconds, 15.0, 7.0));
  EXPECT_EQ(buffer.before(at(1.0), from_seconds(1.5)), nullptr);
  ASSERT_NE(buffer.before(at(2.0), from_seconds(1.5)), nullptr);
  EXPECT_EQ(buffer.before(at(2.0), from_seconds(1.5))->stamp, at(1.0));
  EXPECT_EQ(buffer.before(at(5.0), from_seconds(1.5)), nullptr) << "too old";
}

TEST(Velocity, IsPlausibleOnlyIfBothPartsAre) {
  const auto plausible = [](double speed, double rate) {
    VelocitySample sample;
    sample.linear.x() = speed;
    sample.angular.z() = rate;
    return is_plausible(sample);
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(plausible(30.0, 1.0));
  EXPECT_FALSE(plausible(300.0, 1.0));
  EXPECT_FALSE(plausible(30.0, 1e4));
  EXPECT_FALSE(plausible(kNaN, 1.0));
  EXPECT_FALSE(plausible(30.0, kNaN));
}

// Which samples of a sensor may still come.

struct Sample {
  Stamp stamp = 0;
};

class Stream : public testing::Test {
 protected:
  static Stamp at(double seconds) { return from_seconds(1000.0 + seconds); }
  Insertion insert(double seconds, const std::string& frame = "imu") {
    return stream_.insert({at(seconds)}, frame);
  }
  bool may_still_deliver(double until, double now) const {
    return stream_.may_still_deliver(at(until), {at(now), from_seconds(0.2)});
  }
  SensorStream<Sample> stream_{"imu", true, 0.1};
};

TEST_F(Stream, RefusesKnownStampsAndReportsThatTimeWentBack) {
  EXPECT_EQ(insert(5.0), Insertion::kInserted);
  EXPECT_EQ(insert(5.0), Insertion::kRefused);
  EXPECT_EQ(insert(4.0), Insertion::kInserted) << "late, but new";
  EXPECT_EQ(insert(3.01), Insertion::kInserted);
  EXPECT_EQ(insert(2.99), Insertion::kTimeWentBack);
  EXPECT_EQ(stream_.buffer().size(), 3U) << "nothing is inserted then";
}

TEST_F(Stream, BeginsAgainWithAnotherFrame) {
  insert(5.0);
  insert(5.1);
  EXPECT_EQ(insert(5.2, "other"), Insertion::kInserted);
  EXPECT_EQ(stream_.buffer().size(), 1U);
  EXPECT_EQ(stream_.frame_id(), "other");
}

TEST_F(Stream, GivesTheFirstSampleTimeToArrive) {
  EXPECT_TRUE(may_still_deliver(5.0, 5.19));
  EXPECT_FALSE(may_still_deliver(5.0, 5.21));
}

TEST_F(Stream, WaitsWhileTheSensorSends) {
  insert(4.9);
  EXPECT_TRUE(may_still_deliver(5.0, 5.1));
  EXPECT_FALSE(may_still_deliver(5.0, 5.21)) << "the latency is over";
  EXPECT_FALSE(may_still_deliver(4.9, 5.0)) << "it is there";
}

TEST_F(Stream, DoesNotWaitForASensorThatHasEnded) {
  insert(3.9);
  EXPECT_TRUE(may_still_deliver(5.0, 5.05));
  EXPECT_FALSE(may_still_deliver(5.0, 5.15)) << "silent for a second and the latency";
}

TEST_F(Stream, DoesNotWaitForASensorThatWasGivenUpUntilItDelivers) {
  stream_.give_up_if_silent();
  EXPECT_FALSE(may_still_deliver(5.0, 5.0));
  insert(4.9);
  stream_.give_up_if_silent();
  EXPECT_TRUE(may_still_deliver(5.0, 5.0));
}

TEST_F(Stream, DoesNotWaitForASensorThatIsSwitchedOff) {
  const SensorStream<Sample> off("imu", false, 0.1);
  EXPECT_FALSE(off.may_still_deliver(at(5.0), {at(5.0), from_seconds(0.2)}));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
