#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/degeneracy.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/key_frame_rule.hpp"
#include "lidar_mapping/front_end/match_judge.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/ring_spacing.hpp"
#include "lidar_mapping/front_end/scan_sampler.hpp"
#include "lidar_mapping/front_end/sweep_order.hpp"
#include "lidar_mapping/front_end/twist_forecast.hpp"
#include "lidar_mapping/front_end/velocity_trust.hpp"

namespace lidar_mapping::front_end {
namespace {

Pose turned(double angle) { return {exp_so3({0.0, 0.0, angle}), Eigen::Vector3d::Zero()}; }

// F43: the whole angle counts, whatever the sign of the quaternion.
TEST(KeyFrameRule, ComparesWholeAngles) {
  const KeyFrameRule rule{100.0, 1.0, 0.0};
  for (const double angle : {-3.0, -1.1, -0.9, 0.0, 0.9, 1.1, 3.0}) {
    Pose pose = turned(angle);
    EXPECT_EQ(rule.reached(pose, 0), std::abs(angle) > 1.0) << angle;
    pose.rotation.coeffs() *= -1.0;
    EXPECT_EQ(rule.reached(pose, 0), std::abs(angle) > 1.0) << angle;
  }
}

// F44: the distance is Euclidean, so it does not depend on the direction of the drive.
TEST(KeyFrameRule, MeasuresTheSameInAllDirections) {
  const KeyFrameRule rule{2.0, 1.0, 0.0};
  for (double direction = 0.0; direction < 6.3; direction += 0.1) {
    const Eigen::Vector3d unit(std::cos(direction), std::sin(direction), 0.0);
    EXPECT_FALSE(rule.reached({Eigen::Quaterniond::Identity(), 1.99 * unit}, 0));
    EXPECT_TRUE(rule.reached({Eigen::Quaterniond::Identity(), 2.01 * unit}, 0));
  }
}

TEST(KeyFrameRule, IntervalCountsOnlyWhereItIsSet) {
  EXPECT_FALSE((KeyFrameRule{2.0, 1.0, 0.0}.reached(Pose{}, from_seconds(1e5))));
  EXPECT_TRUE((KeyFrameRule{2.0, 1.0, 5.0}.reached(Pose{}, from_seconds(5.0))));
}

registration::NdtMatch match_of(double overlap, double pair_quality) {
  registration::NdtMatch match;
  match.overlap = overlap;
  match.quality = overlap * pair_quality;
  return match;
}

// A sensor that sees a sector and turns finds few pairs, but good ones; a wrong pose finds bad
// ones.
TEST(MatchJudge, TellsTheEndOfTheMapFromAWrongPose) {
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
TEST(RingSpacing, IsNotHeededInAField) {
  constexpr double kSpacing = 0.03;
  const auto at = [](double x) { return Pose{Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; };
  HeededRings rings(kSpacing);
  EXPECT_EQ(rings.spacing_at(at(0.0)), kSpacing);
  rings.leave_open(at(100.0));
  EXPECT_EQ(rings.spacing_at(at(120.0)), 0.0);
  EXPECT_EQ(rings.spacing_at(at(200.0)), kSpacing);
}

TEST(Deskew, PutsPointsWhereTheMovingSensorWouldHaveSeenThem) {
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
    EXPECT_LT((point.position().cast<double>() - p_world).norm(), 0.02);
    EXPECT_EQ(point.intensity, 7.0F);
  }
}

TEST(Deskew, FollowsASensorThatIsAccelerated) {
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
    EXPECT_LT((point.position().cast<double>() - p_world).norm(), 0.02);
  }
}

// F40, F41: the prediction goes on with the velocity for as long as the stamps say.
TEST(MotionFilter, PredictsWithConstantVelocityOverRealTime) {
  Vector6d twist;
  twist << 30.0, 0.0, 0.0, 0.0, 0.0, 0.3;
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 1.0, 1.0);
  filter.correct({Pose{}, twist}, filter.covariance());
  filter.predict(0.1);
  filter.predict(0.25);
  const Vector6d error = difference(filter.state().T_map_sensor, moved(Pose{}, twist, 0.35));
  EXPECT_LT(error.norm(), 1e-9);
}

/// Where a car is that turns in ever faster, `seconds` after it drove straight.
Pose turning_in(double seconds) {
  Vector6d mean_twist;
  mean_twist << 10.0, 0.0, 0.0, 0.0, 0.0, 0.5 * seconds;
  return moved(Pose{}, mean_twist, seconds);
}

/// What a sweep of a tenth of a second finds there with a twist that is taken to be constant.
MotionState fitted_turning_in(double seconds) {
  Vector6d twist;
  twist << 10.0, 0.0, 0.0, 0.0, 0.0, seconds;
  Vector6d bend = Vector6d::Zero();
  bend[5] = 0.1 * 0.1 / 24.0;
  return {moved(turning_in(seconds), bend, 1.0), twist};
}

TEST(MotionFilter, TheTwistChangesWithinASweepToo) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(turning_in(0.0), 15.0, 1.0);
  EXPECT_EQ(filter.acceleration().norm(), 0.0);
  for (const double seconds : {0.1, 0.2}) {
    filter.predict(0.1);
    filter.correct(fitted_turning_in(seconds), filter.covariance());
  }
  EXPECT_NEAR(filter.acceleration()[5], 1.0, 0.01);
  const MotionState at_stamp =
      steadily_accelerated(filter.state(), filter.acceleration(), 0.1, -0.05);
  EXPECT_LT(rotation_angle(at_stamp.T_map_sensor.rotation.conjugate() * turning_in(0.15).rotation),
            1e-5);
  EXPECT_NEAR(at_stamp.twist[5], 0.15, 1e-3);
  const Pose straight = moved(filter.state().T_map_sensor, filter.state().twist, -0.05);
  EXPECT_GT(rotation_angle(straight.rotation.conjugate() * turning_in(0.15).rotation), 5e-4);
  filter.predict(0.1);
  EXPECT_EQ(filter.acceleration().norm(), 0.0) << "of a prediction nothing is known";
}

TEST(MotionFilter, AJumpIsNoAcceleration) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 15.0, 1.0);
  filter.predict(0.1);
  filter.correct({turning_in(1.0), Vector6d::Zero()}, filter.covariance());
  EXPECT_EQ(filter.acceleration().norm(), 0.0);
}

// F39: a measured speed forward moves the prediction forward.
TEST(MotionFilter, MeasuredVelocityPointsTheRightWay) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(turned(0.5), 15.0, 1.0);
  filter.predict(0.1);
  filter.measure_velocity({10.0, 0.0, 0.0}, 0.1);
  const Eigen::Vector3d expected(std::cos(0.5), std::sin(0.5), 0.0);
  EXPECT_LT((filter.state().T_map_sensor.translation - expected).norm(), 0.05);
  EXPECT_NEAR(filter.state().twist[0], 10.0, 0.1);
}

TEST(MotionFilter, CovarianceStaysValid) {
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose{}, 15.0, 1.0);
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> step(0.01, 2.0);
  for (int i = 0; i < 200; ++i) {
    filter.predict(step(engine));
    filter.measure_rate({0.1, 0.0, 0.2}, 0.1);
    filter.measure_velocity_along(Eigen::Vector3d(0.6, 0.8, 0.0), 3.0, 0.1);
    const Covariance6 covariance =
        pose_covariance(filter.covariance(), filter.state().twist, -0.05);
    ASSERT_TRUE(is_valid_covariance(0.5 * (covariance + covariance.transpose()))) << i;
  }
}

TEST(TwistBetween, IsTheInverseOfMoved) {
  Vector6d twist;
  twist << 12.0, -0.5, 0.3, 0.2, -0.4, 1.5;
  const Pose a = moved(turned(0.7), twist, 3.0);
  EXPECT_LT((twist_between(a, moved(a, twist, 0.4), 0.4) - twist).norm(), 1e-9);
}

TEST(TwistForecast, TakesTheOneThatForetoldBetter) {
  std::mt19937 engine(5);
  std::normal_distribution<double> jitter(0.0, 1.0);
  const Vector6d walk = Vector6d::Constant(1.3);
  TwistForecast of_a_walk(10.0);
  TwistForecast of_a_car(10.0);
  for (int i = 0; i < 200; ++i) {
    const Vector6d gait = Vector6d::NullaryExpr([&](Eigen::Index) { return jitter(engine); });
    of_a_walk.see(walk + 0.05 * gait, walk + gait, 0.1);
    const Vector6d speeding = Vector6d::Constant(0.1 * i);
    of_a_car.see(speeding, speeding + Vector6d::Constant(0.05), 0.1);
  }
  EXPECT_LT((of_a_walk.next(0.1) - walk).norm(), 0.3);
  EXPECT_LT((of_a_car.next(0.1) - Vector6d::Constant(19.95)).tail<3>().norm(), 0.05);
  EXPECT_LT((of_a_car.next(0.1) - Vector6d::Constant(20.0)).head<3>().norm(), 1e-6);
}

TEST(TwistForecast, GoesOnWithAnAccelerationForAsLongAsTheNextStepTakes) {
  TwistForecast forecast(10.0);
  const double acceleration = -2.0;
  double time = 0.0;
  for (int step = 0; step < 100; ++step) {
    const double seconds = step % 3 == 0 ? 0.2 : 0.1;
    Vector6d mean_twist = Vector6d::Zero();
    mean_twist[0] = 30.0 + acceleration * (time + 0.5 * seconds);
    mean_twist[2] = step % 2 == 0 ? 0.1 : -0.1;
    Vector6d sweep_twist = mean_twist;
    time += seconds;
    sweep_twist[0] = 30.0 + acceleration * time;
    forecast.see(mean_twist, sweep_twist, seconds);
  }
  EXPECT_NEAR(forecast.next(0.3)[0], 30.0 + acceleration * (time + 0.15), 1e-6);
  EXPECT_NEAR(forecast.at_end_of_next(0.3)[0], 30.0 + acceleration * (time + 0.3), 1e-6);
  // What goes up and down from step to step is not carried on.
  EXPECT_EQ(forecast.at_end_of_next(0.3)[2], forecast.next(0.3)[2]);
}

TEST(TwistForecast, TakesAJumpOfThePoseForNoAcceleration) {
  TwistForecast forecast(10.0);
  Vector6d twist = Vector6d::Zero();
  for (int step = 0; step < 30; ++step) {
    twist[0] = 0.2 * step;
    forecast.see(twist, twist, 0.1);
  }
  EXPECT_GT(forecast.at_end_of_next(0.1)[0] - forecast.next(0.1)[0], 0.09);
  twist[0] += 3.0;
  forecast.see(twist, twist, 0.1);
  EXPECT_EQ(forecast.at_end_of_next(0.1)[0], forecast.next(0.1)[0]);
}

// A prediction that lags behind pulls each pose back while the vehicle speeds up and ahead while it
// brakes. Both go into the map and stay, and as the points say less at speed, streets grow.
TEST(MotionFilter, DoesNotLagBehindABrakingVehicle) {
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  constexpr double kStep = 0.1, kAcceleration = -1.8;
  const Matrix12d covariance = Vector12d::Constant(1e-5).asDiagonal().toDenseMatrix();
  MotionFilter filter(10.0, 5.0);
  filter.reset(Pose::Identity(), 15.0, 1.0);
  std::vector<double> behind;
  for (int i = 0; i < 60; ++i) {
    const double t = kStep * i;
    Vector6d twist = Vector6d::Zero();
    twist[0] = 14.0 + kAcceleration * t;
    Pose pose;
    pose.translation.x() = 14.0 * t + 0.5 * kAcceleration * t * t + noise(engine);
    if (i > 0) filter.predict(kStep);
    if (i > 20)
      behind.push_back(filter.state().T_map_sensor.translation.x() - pose.translation.x());
    filter.correct({pose, twist}, covariance);
  }
  const double mean =
      std::accumulate(behind.begin(), behind.end(), 0.0) / static_cast<double>(behind.size());
  EXPECT_LT(std::abs(mean), 0.003) << "0.011 with a constant twist";
}

TEST(TwistForecast, KnowsASteadyAccelerationFromAGait) {
  TwistForecast forecast(10.0);
  for (int step = 0; step < 100; ++step) {
    // Forward ever faster, up and down from step to step, and not at all about z.
    Vector6d mean_twist = Vector6d::Zero();
    mean_twist[0] = 0.1 * step;
    Vector6d sweep_twist = mean_twist;
    sweep_twist[0] += 0.05;
    sweep_twist[2] = step % 2 == 0 ? 0.1 : -0.1;
    forecast.see(mean_twist, sweep_twist, 0.1);
  }
  EXPECT_NEAR(forecast.steadiness()[0], 1.0, 1e-9);
  EXPECT_EQ(forecast.steadiness()[2], 0.0);
  EXPECT_EQ(forecast.steadiness()[5], 0.0);
}

TEST(VelocityTrust, LearnsTheScaleAndWhatTheVelocityIsWorth) {
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.1);
  VelocityTrust wheels;
  VelocityTrust dead;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d velocity(10.0, 0.0, 0.0);
    wheels.see(1.02 * velocity + Eigen::Vector3d(noise(engine), noise(engine), 0.0), velocity);
    dead.see(Eigen::Vector3d::Zero(), velocity);
  }
  EXPECT_NEAR(wheels.corrected({10.2, 0.0, 0.0}).x(), 10.0, 0.03);
  EXPECT_NEAR(wheels.usual_sigma(), 0.08, 0.03);
  EXPECT_GT(dead.cautious_sigma(0.0), 5.0);
  EXPECT_GT(dead.usual_sigma(), 3.0);
}

// F47: long chains of motions stay rotations.
TEST(Moved, StaysARotationOverAHundredThousandSteps) {
  Vector6d twist;
  twist << 10.0, 0.0, 0.0, 0.01, -0.02, 0.3;
  Pose pose;
  for (int i = 0; i < 100000; ++i) pose = moved(pose, twist, 0.1);
  EXPECT_NEAR(pose.rotation_matrix().determinant(), 1.0, 1e-9);
}

TEST(Degeneracy, FindsTheAxisOfATunnel) {
  Matrix6d H = Matrix6d::Identity() * 1e6;
  H(0, 0) = 10.0;
  const auto directions = degenerate_directions(H);
  ASSERT_EQ(directions.size(), 1U);
  EXPECT_NEAR(std::abs(directions[0].x()), 1.0, 1e-6);
  EXPECT_TRUE(degenerate_directions(Matrix6d::Identity()).empty());
  const Eigen::Vector3d beside = projection_beside(directions) * Eigen::Vector3d(3.0, 2.0, 1.0);
  EXPECT_LT((beside - Eigen::Vector3d(0.0, 2.0, 1.0)).norm(), 1e-6);
}

PointCloud random_cloud(std::size_t count) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> coordinate(-40.0F, 40.0F);
  PointCloud cloud;
  while (cloud.size() < count) {
    cloud.points.push_back({coordinate(engine), coordinate(engine), coordinate(engine), 0.0F});
  }
  return cloud;
}

TEST(ScanSampler, TakesAtMostOnePointPerCube) {
  PointCloud cloud = random_cloud(20000);  // 8000 cubes
  ScanSampler sampler(17);
  const auto indices = sampler.sample(cloud, {4.0, 0.0, 1000.0, 1, 0});
  EXPECT_GT(indices.size(), 4000U);
  EXPECT_LE(indices.size(), 8000U);
  EXPECT_EQ(sampler.sample(cloud, {4.0, 0.0, 1000.0, 1, 0}), indices);
}

/// A wall 10.2 m to the left, as a sensor that turns clockwise sees it, firing by firing.
PointCloud swept_wall() {
  std::mt19937 engine(3);
  std::normal_distribution<float> noise(0.0F, 0.02F);
  PointCloud cloud;
  for (int column = 0; column < 4000; ++column) {
    const float azimuth = 2.8F - 2.46F * static_cast<float>(column) / 4000.0F;
    for (int beam = 0; beam < 16; ++beam) {
      const float range = 10.2F / std::sin(azimuth) + noise(engine);
      const float height = 0.02F * static_cast<float>(beam - 8) * range;
      cloud.points.push_back({range * std::cos(azimuth), range * std::sin(azimuth), height, 0.0F});
    }
  }
  return cloud;
}

/// Slope over x of the mean distance of the sampled points from the wall.
double leaning(const PointCloud& cloud, bool scattered) {
  ScanSampler sampler(17);
  double products = 0.0;
  double squares = 0.0;
  for (const std::uint32_t i : sampler.sample(cloud, {0.4, 0.0, 1000.0, 1, 0, scattered})) {
    const Point& p = cloud.points[i];
    products += p.x * (p.y - 10.2);
    squares += p.x * p.x;
  }
  return products / squares;
}

// Coming in across the side of a cube, of the noise the nearer points win on the one half of a wall
// and the farther ones on the other.
TEST(ScanSampler, AWallDoesNotLeanToWhereTheSweepComesFrom) {
  const PointCloud cloud = swept_wall();
  EXPECT_LT(std::abs(leaning(cloud, true)), 0.3 * std::abs(leaning(cloud, false)));
}

TEST(ScanSampler, ScatteringLooksAtEachPointOnce) {
  const PointCloud cloud = random_cloud(5000);
  ScanSampler sampler(20);
  for (const std::size_t stride : {1U, 3U, 9U, 5000U}) {
    std::vector<std::uint32_t> indices =
        sampler.sample(cloud, {1e-3, 0.0, 1000.0, stride, 0, true});
    std::sort(indices.begin(), indices.end());
    EXPECT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end()) << stride;
    EXPECT_EQ(indices.size(), sampler.sample(cloud, {1e-3, 0.0, 1000.0, stride, 0, false}).size());
  }
}

TEST(SweepOrder, IsThatOfTheFirings) {
  PointCloud cloud;
  for (int column = 0; column < 900; ++column) {
    const float azimuth = -0.007F * static_cast<float>(column);
    for (int ring = 0; ring < 16; ++ring) {
      cloud.points.push_back({20.0F * std::cos(azimuth), 20.0F * std::sin(azimuth), 0.0F, 0.0F});
    }
  }
  EXPECT_TRUE(in_sweep_order(cloud));
  PointCloud by_rings;
  for (std::size_t ring = 0; ring < 16; ++ring) {
    for (std::size_t column = 0; column < 900; ++column) {
      by_rings.points.push_back(cloud.points[16 * column + ring]);
    }
  }
  EXPECT_FALSE(in_sweep_order(by_rings));
  EXPECT_FALSE(in_sweep_order(PointCloud{}));
}

TEST(ScanSampler, LeavesOutPointsThatAreNotFiniteOrOutOfRange) {
  PointCloud cloud;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  cloud.points = {
      {nan, 0, 0, 0}, {5, infinite, 0, 0}, {0.5F, 0, 0, 0}, {200, 0, 0, 0}, {5, 5, 5, 0}};
  ScanSampler sampler(10);
  EXPECT_EQ(sampler.sample(cloud, {1.0, 1.0, 100.0, 1, 0}), std::vector<std::uint32_t>{4});
}

TEST(ScanSampler, SamplesAlikeAfterTheGenerationNumberHasWrapped) {
  const PointCloud cloud = random_cloud(500);
  ScanSampler sampler(14);
  const auto first = sampler.sample(cloud, {1.0, 0.0, 1000.0, 1, 0});
  for (int i = 0; i < 600; ++i) {
    ASSERT_EQ(sampler.sample(cloud, {1.0, 0.0, 1000.0, 1, 0}), first) << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
