// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/antenna_fit.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"

#include "gnss/fix_scatter.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using lidar_mapping::test::near;
using test::append;
using test::at;

/// A slalom at a speed that changes, in East-North-Up and (turned) by dead reckoning; the fixes are
/// `delay` seconds late and the antenna is `arm_error` beside its place in tf.
AntennaFit slalom(double delay, const Eigen::Vector2d& arm_error) {
  AntennaFit fit;
  const Eigen::Vector2d arm(-0.4, 0.5);
  const Eigen::Matrix2d R_enu_dr = Eigen::Rotation2Dd(1.1).toRotationMatrix();
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.02);
  const auto speed = [](double t) { return 8.0 + 3.0 * std::sin(0.5 * t); };
  const auto yaw = [](double t) { return 0.9 * std::sin(0.35 * t); };
  const double step = 0.001;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  for (int i = 0; i < 60000; ++i) {
    const double t = i * step;
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(yaw(t)).toRotationMatrix();
    const Eigen::Vector2d v_base(speed(t), 0.0);
    if (i % 100 == 0) {
      const double rate = 0.9 * 0.35 * std::cos(0.35 * t);
      const auto velocity = [&](const Eigen::Vector2d& l) -> Eigen::Vector2d {
        return R * (v_base + rate * Eigen::Vector2d(-l.y(), l.x()));
      };
      const Eigen::Vector2d true_arm = arm + arm_error;
      TrackedFix fix;
      fix.stamp = at(t);
      const Eigen::Vector2d antenna = p + R * true_arm - delay * velocity(true_arm);
      fix.p_enu = R_enu_dr * antenna + Eigen::Vector2d(noise(engine), noise(engine));
      fix.yaw_dr = yaw(t);
      fix.p_dr_base = p;
      fix.v_dr = velocity(arm);
      fix.p_base_antenna = arm;
      fit.add(fix);
    }
    p += step * (R * v_base);
  }
  return fit;
}

TEST(AntennaFit, FindsTheDelayOfTheStamps) {
  for (const double delay : {-0.1, 0.0, 0.05}) {
    const auto result = slalom(delay, Eigen::Vector2d::Zero()).result(0.03);
    EXPECT_NEAR(result.delay, delay, 0.005);
    EXPECT_LT(result.delay_sigma, 0.01);
  }
}

TEST(AntennaFit, FindsThePositionOfTheAntenna) {
  const Eigen::Vector2d arm_error(1.2, -0.9);
  const auto result = slalom(0.0, arm_error).result(3.0);
  EXPECT_TRUE(near(result.arm_error, arm_error, 0.2));
  EXPECT_LT(result.arm_sigma, 0.2);
}

TEST(AntennaFit, IsUnknownForAStandingVehicle) {
  AntennaFit fit;
  for (int i = 0; i < 600; ++i) {
    TrackedFix fix;
    fix.stamp = at(0.1 * i);
    fit.add(fix);
  }
  EXPECT_NEAR(fit.result(0.03).delay, 0.0, 1e-9);
  EXPECT_GT(fit.result(0.03).delay_sigma, 0.1);
}

FixScatter scatter_of(double true_sigma, double stated_sigma) {
  FixScatter scatter;
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, true_sigma);
  for (int i = 0; i < 300; ++i) {
    LocalFix fix;
    fix.stamp = at(0.1 * i);
    fix.p_enu = {0.8 * i + noise(engine), noise(engine), 0.0};
    fix.covariance = stated_sigma * stated_sigma * Eigen::Matrix3d::Identity();
    scatter.add(fix);
  }
  return scatter;
}

TEST(FixScatter, RaisesOnlyCovariancesThatAreTooSmall) {
  EXPECT_NEAR(std::sqrt(scatter_of(1.0, 0.1).variance_factor()), 10.0, 2.0);
  EXPECT_EQ(scatter_of(1.0, 1.0).variance_factor(), 1.0);
  EXPECT_EQ(scatter_of(0.1, 1.0).variance_factor(), 1.0);
}

/// The extrinsic was applied the wrong way round. A wall north of a vehicle that drives a bend
/// must be straight after the compensation of the motion, seen by a sensor that is turned by 90
/// degrees and a metre off: velocity and rate are measured in base_link, the points in its frame.
TEST(Preprocessor, AppliesTheExtrinsicInTheRightDirection) {
  const Pose T_base_lidar{exp_so3({0.0, 0.0, M_PI / 2.0}), {1.0, 0.0, 0.5}};
  Preprocessor stage({}, [&](const std::string& frame) {
    return frame == "lidar" ? T_base_lidar : Pose::Identity();
  });
  constexpr double kSpeed = 10.0;     // m/s
  constexpr double kYawRate = 0.4;    // rad/s
  constexpr double kDuration = 0.09;  // s, of a scan after its stamp
  const auto T_map_base = [&](double t) {
    const double yaw = kYawRate * t;
    const double radius = kSpeed / kYawRate;
    return Pose{exp_so3({0.0, 0.0, yaw}),
                {radius * std::sin(yaw), radius * (1.0 - std::cos(yaw)), 0.0}};
  };
  std::vector<SyncedScan> scans;
  for (int tick = 0; tick < 120; ++tick) {
    const double t = 0.01 * tick;
    stage.add_imu(test::imu(at(t), {0.0, 0.0, kYawRate}), "imu");
    stage.add_velocity(test::velocity(at(t), {kSpeed, 0.0, 0.0}, {0.0, 0.0, kYawRate}), "imu");
    if (tick % 10 != 5) continue;
    RawScan scan;
    scan.stamp = at(t);
    scan.frame_id = "lidar";
    for (int i = 0; i <= 100; ++i) {
      const double after = kDuration * i / 100.0;
      const Eigen::Vector3d p_map(0.1 * i, 25.0, 1.0);
      const Eigen::Vector3f p =
          ((T_map_base(t + after) * T_base_lidar).inverse() * p_map).cast<float>();
      scan.cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
      scan.cloud.times.push_back(static_cast<float>(after));
    }
    append(scans, stage.process(std::move(scan)));
  }
  append(scans, stage.flush());
  ASSERT_EQ(scans.size(), 12U);
  scans.pop_back();  // nothing was measured until its end
  for (const SyncedScan& scan : scans) {
    ASSERT_FALSE(scan.scan.cloud.has_times()) << "the motion is compensated";
    const Pose T_map_lidar = T_map_base(to_seconds(scan.scan.stamp - at(0.0))) * T_base_lidar;
    for (std::size_t i = 0; i < scan.scan.cloud.size(); ++i) {
      const Eigen::Vector3d p_map =
          T_map_lidar * scan.scan.cloud.points[i].position().cast<double>();
      ASSERT_NEAR(p_map.x(), 0.1 * static_cast<double>(i), 0.005);
      ASSERT_NEAR(p_map.y(), 25.0, 0.005);
      ASSERT_NEAR(p_map.z(), 1.0, 0.005);
    }
  }
}

TEST(Preprocessor, AcceptsLateImuSamplesOfAnyRate) {
  for (const double rate : {100.0, 400.0, 1000.0}) {
    Preprocessor stage({}, test::identity_lookup);
    std::vector<SyncedScan> scans;
    double next = 0.0;
    for (int tick = 0; tick < 300; ++tick) {
      for (; next + 0.15 <= 0.01 * tick; next += 1.0 / rate) {
        stage.add_imu(test::imu(at(next), {0.0, 0.0, 0.2}), "imu");
        append(scans, stage.take_complete());
      }
      if (tick % 10 == 5) append(scans, stage.process(test::ring_scan(at(0.01 * tick))));
    }
    append(scans, stage.flush());
    ASSERT_EQ(scans.size(), 30U) << rate;
    std::size_t with_imu = 0;
    for (const SyncedScan& scan : scans) with_imu += scan.imu.has_value() ? 1 : 0;
    EXPECT_GE(with_imu, 27U) << rate;
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
