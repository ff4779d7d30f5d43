// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/front_end/status_warnings.hpp"

#include "judgement/match_judge.hpp"
#include "key_frame_rule.hpp"
#include "matching/degeneracy.hpp"
#include "motion/motion_filter.hpp"
#include "near.hpp"
#include "scan/ring_spacing.hpp"

namespace lidar_mapping::front_end {
namespace {

Pose turned(double angle) { return {exp_so3({0.0, 0.0, angle}), Eigen::Vector3d::Zero()}; }

TEST(FrontEndConfig, AcceptsTheParametersOfHdlGraphSlam) {
  const auto config = config::load<FrontEndConfig>(
      {config::parse_yaml("keyframe_delta_trans: 5.0\nkeyframe_delta_angle: 1.0\n"
                          "keyframe_delta_time: 10000.0\n",
                          "hdl")});
  EXPECT_EQ(config.key_frame_distance, 5.0);
  EXPECT_EQ(config.key_frame_angle, 1.0);
  EXPECT_EQ(config.key_frame_interval, 10000.0);
}

// The whole angle counts, whatever the sign of the quaternion.
TEST(KeyFrameRule, ComparesWholeAngles) {
  const KeyFrameRule rule{100.0, 1.0, 0.0};
  for (const double angle : {-3.0, -1.1, -0.9, 0.0, 0.9, 1.1, 3.0}) {
    Pose pose = turned(angle);
    EXPECT_EQ(rule.reached(pose, 0), std::abs(angle) > 1.0) << angle;
    pose.rotation.coeffs() *= -1.0;
    EXPECT_EQ(rule.reached(pose, 0), std::abs(angle) > 1.0) << angle;
  }
}

// The distance is Euclidean, so it does not depend on the direction of the drive.
TEST(KeyFrameRule, MeasuresTheSameInAllDirections) {
  const KeyFrameRule rule{2.0, 1.0, 0.0};
  for (double direction = 0.0; direction < 6.3; direction += 0.1) {
    const Eigen::Vector3d unit(std::cos(direction), std::sin(direction), 0.0);
    EXPECT_FALSE(rule.reached({Eigen::Quaterniond::Identity(), 1.99 * unit}, 0));
    EXPECT_TRUE(rule.reached({Eigen::Quaterniond::Identity(), 2.01 * unit}, 0));
  }
}

TEST(KeyFrameRule, IntervalIsUsedOnlyIfSet) {
  EXPECT_FALSE((KeyFrameRule{2.0, 1.0, 0.0}.reached(Pose{}, from_seconds(1e5))));
  const KeyFrameRule timed{2.0, 1.0, 5.0};
  EXPECT_TRUE(timed.reached(Pose{}, from_seconds(5.0)));
  EXPECT_FALSE(timed.motion_reached(Pose{}));
  EXPECT_TRUE(timed.motion_reached({Eigen::Quaterniond::Identity(), {2.0, 0.0, 0.0}}));
}

registration::NdtMatch match_of(double overlap, double pair_quality) {
  registration::NdtMatch match;
  match.overlap = overlap;
  match.quality = overlap * pair_quality;
  return match;
}

// A sensor that sees a sector and turns finds few pairs, but good ones; a wrong pose finds bad
// ones.
TEST(MatchJudge, DistinguishesTheEndOfTheMapFromAWrongPose) {
  MatchJudge judge(50.0);
  const registration::MotionBelief anywhere{{}, Matrix12d::Identity()};
  for (int scan = 0; scan < 50; ++scan) judge.learn(match_of(0.8, 0.85));
  EXPECT_EQ(judge.judge(match_of(0.8, 0.85), anywhere), TrackingState::kTracking);
  EXPECT_EQ(judge.judge(match_of(0.25, 0.80), anywhere), TrackingState::kTracking);
  EXPECT_EQ(judge.judge(match_of(0.25, 0.65), anywhere), TrackingState::kLost);
  EXPECT_EQ(judge.judge(match_of(0.50, 0.65), anywhere), TrackingState::kDegraded);
  EXPECT_EQ(judge.judge(match_of(0.10, 0.85), anywhere), TrackingState::kLost);
  EXPECT_TRUE(judge.in_doubt(match_of(0.25, 0.80), anywhere));
}

/// What a sensor at p_base_sensor, a little askew, sees of a round room of 20 m with its beams from
/// 12 degrees below the horizon to 12 above it.
PointCloud seen_by(int beams, const Eigen::Vector3d& p_base_sensor) {
  const Pose T_base_sensor{exp_so3({0.006, 0.009, -0.3}), p_base_sensor};
  PointCloud cloud;
  for (int column = 0; column < 1000; ++column) {
    for (int beam = 0; beam < beams; ++beam) {
      const double elevation = 0.42 * (static_cast<double>(beam) / (beams - 1) - 0.5);
      const double azimuth = 2.0 * M_PI * column / 1000.0;
      const Eigen::Vector3d ray(std::cos(azimuth), std::sin(azimuth), std::tan(elevation));
      const Eigen::Vector3f p = (T_base_sensor * Eigen::Vector3d(20.0 * ray)).cast<float>();
      cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
    }
  }
  return cloud;
}

TEST(RingSpacing, IsTheAngleBetweenNeighbouringBeams) {
  const Eigen::Vector3d origin(0.8, 0.0, 1.7);
  EXPECT_NEAR(ring_spacing(seen_by(16, origin), origin), 0.42 / 15.0, 0.002);
  EXPECT_NEAR(ring_spacing(seen_by(64, origin), origin), 0.42 / 63.0, 0.002);
}

TEST(RingSpacing, IsZeroWithoutRings) {
  const Eigen::Vector3d origin(0.8, 0.0, 1.7);
  EXPECT_EQ(ring_spacing(PointCloud{}, origin), 0.0);
  EXPECT_EQ(ring_spacing(seen_by(500, origin), origin), 0.0);
  // On its side, the sensor spins about another axis.
  PointCloud aside = seen_by(16, Eigen::Vector3d::Zero());
  for (Point& point : aside.points) std::swap(point.y, point.z);
  EXPECT_LT(ring_spacing(aside, Eigen::Vector3d::Zero()), 0.005);
}

// Where a field leaves a direction open the planes of leaves are all that there is.
TEST(RingSpacing, IsNotUsedInAnOpenField) {
  constexpr double kSpacing = 0.03;
  const auto at = [](double x) { return Pose{Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; };
  RingSpacingGate rings(kSpacing);
  EXPECT_EQ(rings.spacing_at(at(0.0)), kSpacing);
  rings.mark_open_field(at(100.0));
  EXPECT_EQ(rings.spacing_at(at(120.0)), 0.0);
  EXPECT_EQ(rings.spacing_at(at(200.0)), kSpacing);
}

TEST(Deskew, MovesPointsToWhereTheSensorWouldHaveMeasuredThem) {
  Vector6d twist;
  twist << 20.0, -0.5, 0.1, 0.1, -0.2, 1.2;
  const Eigen::Vector3d p_world(30.0, -12.0, 2.0);
  PointCloud cloud;
  for (const float s : {-0.05F, 0.0F, 0.05F, 0.1F}) {
    const Pose T_world_sensor = moved(Pose{}, twist, s);
    const Eigen::Vector3f p = (T_world_sensor.inverse() * p_world).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), 7.0F});
    cloud.times.push_back(s);
  }
  const PointCloud result = deskewed(cloud, twist);
  EXPECT_FALSE(result.has_times());
  for (const Point& point : result.points) {
    EXPECT_TRUE(test::near(point.position().cast<double>(), p_world, 0.02));
    EXPECT_EQ(point.intensity, 7.0F);
  }
}

TEST(Deskew, HandlesAnAcceleratedSensor) {
  Vector6d twist, acceleration;
  twist << 10.0, 0.0, 0.0, 0.0, 0.0, 0.3;
  acceleration << -4.0, 1.0, 0.0, 0.0, 0.5, 2.0;
  const Eigen::Vector3d p_world(30.0, -12.0, 2.0);
  PointCloud cloud;
  for (const float s : {0.0F, 0.05F, 0.1F}) {
    const Pose T_world_sensor = moved(Pose{}, twist + 0.5 * s * acceleration, s);
    const Eigen::Vector3f p = (T_world_sensor.inverse() * p_world).cast<float>();
    cloud.points.push_back({p.x(), p.y(), p.z(), 7.0F});
    cloud.times.push_back(s);
  }
  for (const Point& point : deskewed(cloud, twist, acceleration).points) {
    EXPECT_TRUE(test::near(point.position().cast<double>(), p_world, 0.02));
  }
}

TEST(Degeneracy, FindsTheAxisOfATunnel) {
  Matrix6d H = Matrix6d::Identity() * 1e6;
  H(0, 0) = 10.0;
  const auto directions = degenerate_directions(H);
  ASSERT_EQ(directions.size(), 1U);
  EXPECT_NEAR(std::abs(directions[0].x()), 1.0, 1e-6);
  EXPECT_TRUE(degenerate_directions(Matrix6d::Identity()).empty());
  const Eigen::Vector3d beside =
      projection_orthogonal_to(directions) * Eigen::Vector3d(3.0, 2.0, 1.0);
  EXPECT_TRUE(test::near(beside, Eigen::Vector3d(0.0, 2.0, 1.0), 1e-6));
}

TEST(StatusWarnings, AreOnesForEachThingThatIsWrong) {
  EXPECT_TRUE(warnings_of(FrontEndStatus{}).empty());
  FrontEndStatus status;
  status.map_points_dropped = 7;
  status.gyro_distrusted = true;
  status.velocity_distrusted = true;
  const std::vector<StatusWarning> warnings = warnings_of(status);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].key, kFullMapKey);
  EXPECT_NE(warnings[0].text.find(" 7 points"), std::string::npos);
  EXPECT_NE(warnings[0].text.find("voxel_size"), std::string::npos);
  EXPECT_NE(warnings[1].text.find("the gyro does not agree"), std::string::npos);
  EXPECT_NE(warnings[2].text.find("velocity: it does not agree"), std::string::npos);
}

TEST(PriorOf, TreatsAZeroRotationRateOfTheVelocityAsNotMeasured) {
  ImuSample imu;
  imu.angular_velocity = {0.0, 0.0, 0.2};
  VelocitySample velocity;
  velocity.linear = {3.0, 0.0, 0.0};
  MotionPrior prior = prior_of(imu, velocity, std::nullopt, std::nullopt, std::nullopt);
  EXPECT_EQ(prior.angular_velocity.value(), imu.angular_velocity);
  EXPECT_EQ(prior.linear_velocity.value(), velocity.linear);
  EXPECT_FALSE(prior.velocity_turning);
  velocity.angular = {0.0, 0.0, 0.1};
  imu.has_angular_velocity = false;
  prior = prior_of(imu, velocity, std::nullopt, std::nullopt, std::nullopt);
  EXPECT_FALSE(prior.angular_velocity);
  EXPECT_EQ(prior.velocity_turning.value(), velocity.angular);
}

}  // namespace
}  // namespace lidar_mapping::front_end
