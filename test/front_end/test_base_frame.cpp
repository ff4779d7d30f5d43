// SPDX-License-Identifier: BSD-3-Clause
// The choice of base_link decides to which frame poses belong, and nothing else.

#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/front_end/corrected_cloud.hpp"

#include "base_frame.hpp"
#include "base_frames.hpp"
#include "evaluated_drive.hpp"
#include "motion/motion_filter.hpp"
#include "near.hpp"

namespace lidar_mapping::front_end {
namespace {

std::vector<test::OtherBase> other_bases() {
  return {test::other_base("rear axle, driven backwards", {-1.5, 0.0, -1.5}, 180.0, 0.0, 0.0),
          test::other_base("on its back", {0.5, -0.5, 1.5}, 0.0, 30.0, 180.0),
          test::other_base("corner", {1.5, 1.5, 0.0}, 90.0, -20.0, 10.0)};
}

struct Case {
  const char* drive;
  const char* imu;
  bool with_others;
};

class OtherBaseLink : public testing::TestWithParam<Case> {};

TEST_P(OtherBaseLink, GivesTheSamePosesOfTheSensor) {
  simulation::DriveOptions options = drive_options(GetParam().drive, 10.0, 13);
  options.imu = GetParam().imu;
  const simulation::Drive drive(options);
  const test::SensorData data = test::sensor_data(drive, GetParam().with_others);
  const test::SensorTrack usual = test::OdometryInOtherBase(data, {"usual", {}}).run();
  ASSERT_GT(usual.T_first_lidar.size(), 95U);
  EXPECT_EQ(usual.lost, 0U);
  for (const test::OtherBase& other : other_bases()) {
    SCOPED_TRACE(other.name);
    const test::SensorTrack track = test::OdometryInOtherBase(data, other).run();
    const test::TrackDifference difference = test::difference_of(usual, track);
    EXPECT_LT(difference.metres, 0.001);
    EXPECT_LT(difference.degrees, 0.01);
    EXPECT_EQ(track.key_frames, usual.key_frames);
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, OtherBaseLink,
                         testing::Values(Case{"town", "good", true}, Case{"town", "good", false},
                                         Case{"handheld", "consumer", true}),
                         [](const auto& test_case) {
                           return std::string(test_case.param.drive) +
                                  (test_case.param.with_others ? "" : "_lidar_alone");
                         });

/// A result that belongs to the LiDAR's frame.
FrontEndResult some_result() {
  FrontEndResult result;
  result.T_odom_base = {exp_so3({0.1, -0.2, 0.7}), {3.0, 1.0, -0.5}};
  result.twist << 4.0, 0.2, -0.1, 0.05, -0.1, 0.6;
  result.acceleration << 1.0, -0.5, 0.3, 0.2, 0.1, -0.4;
  Matrix6d root;
  std::mt19937 engine(3);
  std::normal_distribution<double> normal(0.0, 0.1);
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = normal(engine);
  result.covariance = root * root.transpose();
  return result;
}

const Pose kBaseSensor{exp_so3({0.4, 1.0, -2.0}), {1.5, -0.7, 1.2}};

BaseFrame border() {
  BaseFrame frame;
  frame.set_sensor_pose(kBaseSensor);
  frame.set_start({exp_so3({0.0, 0.0, 1.0}), {100.0, 50.0, 2.0}});
  return frame;
}

TEST(BaseFrame, ConvertsTheTwistToBaseLink) {
  const BaseFrame frame = border();
  FrontEndResult now = some_result();
  FrontEndResult later = now;
  later.T_odom_base = moved(now.T_odom_base, now.twist, 0.3);
  const Pose expected = frame.of_base(later).T_odom_base;
  now = frame.of_base(now);
  EXPECT_TRUE(test::near(moved(now.T_odom_base, now.twist, 0.3), expected, 1e-9));
}

TEST(BaseFrame, ConvertsTheCovarianceToBaseLink) {
  const BaseFrame frame = border();
  const FrontEndResult of_sensor = some_result();
  const FrontEndResult of_base = frame.of_base(of_sensor);
  // Each column is the change of base_link's pose by a small error of the LiDAR's pose.
  Matrix6d J;
  for (int axis = 0; axis < 6; ++axis) {
    FrontEndResult off = of_sensor;
    off.T_odom_base = perturbed(of_sensor.T_odom_base, Vector6d(1e-6 * Vector6d::Unit(axis)));
    J.col(axis) = difference(of_base.T_odom_base, frame.of_base(off).T_odom_base) / 1e-6;
  }
  EXPECT_TRUE(test::near(of_base.covariance, J * of_sensor.covariance * J.transpose(), 1e-5));
}

TEST(BaseFrame, ConvertsVelocitiesWithTheLeverArm) {
  const BaseFrame frame = border();
  const FrontEndResult of_base = frame.of_base(some_result());
  const Eigen::Vector3d v = some_result().twist.head<3>();
  const Eigen::Vector3d omega = some_result().twist.tail<3>();
  MotionPrior prior;
  prior.linear_velocity = of_base.twist.head<3>();
  EXPECT_TRUE(test::near(*frame.of_sensor(prior, omega).linear_velocity, v, 1e-9))
      << "as last seen";
  const Eigen::Vector3d unknown(0.0, 0.0, 9.0);
  prior.angular_velocity = of_base.twist.tail<3>();
  EXPECT_TRUE(test::near(*frame.of_sensor(prior, unknown).linear_velocity, v, 1e-9))
      << "by the gyro";
  EXPECT_TRUE(test::near(*frame.of_sensor(prior, unknown).angular_velocity, omega, 1e-9));
  prior.velocity_turning = of_base.twist.tail<3>();
  prior.angular_velocity->z() += 1.0;
  EXPECT_TRUE(test::near(*frame.of_sensor(prior, unknown).linear_velocity, v, 1e-9))
      << "by its own";
}

// A key frame's pose and its cloud both belong to base_link.
TEST(BaseFrame, KeyFramesAreInBaseLink) {
  const simulation::Drive drive = make_drive("town", 3.0, 1);
  EvaluatedDrive ride(drive);
  std::optional<KeyFrame> key_frame;
  for (std::size_t i = 0; i < 20 && !key_frame; ++i) {
    const FrontEndResult& result = ride.process(i);
    for (const FrontEndResult& finalized : result.finalized) {
      if (finalized.key_frame) key_frame = finalized.key_frame;
    }
    if (result.key_frame) key_frame = result.key_frame;
  }
  ASSERT_TRUE(key_frame);
  EXPECT_TRUE(test::near(key_frame->T_odom_base, Pose::Identity(), 0.02)) << "at its start";
  // The ground lies where base_link stands on it.
  std::size_t on_ground = 0;
  for (const Point& p : key_frame->cloud->points) {
    if (std::hypot(p.x, p.y) < 15.0F && std::abs(p.z) < 0.15F) ++on_ground;
  }
  EXPECT_GT(on_ground, 500U);
}

// The rotation that the gyro removed from a scan and the force that the accelerometer measured are
// converted, too.
TEST(BaseFrame, RotatesGyroAndAccelerometerIntoTheLidarsAxes) {
  const Pose T_base_sensor{exp_so3({0.1, -0.4, 1.2}), {1.0, -0.5, 1.8}};
  BaseFrame frame;
  frame.set_sensor_pose(T_base_sensor);
  const Eigen::Quaterniond turning = exp_so3({0.03, 0.01, -0.02});
  MotionPrior prior;
  prior.uneven_turning = UnevenTurning{0.0, 0.1, {turning, turning}};
  prior.felt = FeltForce{5, {0.3, 0.2, 9.8}, {0.2, 0.0, 1.0}};
  const MotionPrior over = frame.of_sensor(prior, Eigen::Vector3d::Zero());
  const Eigen::Vector3d v_sensor(3.0, -2.0, 0.7);
  const Eigen::Vector3d v_base = T_base_sensor.rotation * v_sensor;
  EXPECT_TRUE((T_base_sensor.rotation * (over.uneven_turning->R_stamp_knot[0] * v_sensor))
                  .isApprox(turning * v_base, 1e-12));
  EXPECT_TRUE((T_base_sensor.rotation * over.felt->mean).isApprox(prior.felt->mean, 1e-12));
  EXPECT_TRUE((T_base_sensor * over.felt->p_base_imu).isApprox(prior.felt->p_base_imu, 1e-12));
  EXPECT_EQ(over.felt->since, 5);
}

/// The front end has put the gyro's correction back in the LiDAR's axes; here it is the whole
/// motion.
TEST(CorrectedCloud, PutsTheGyrosCorrectionBackIfTheFrontEndDid) {
  const Pose T_base_lidar{exp_so3({0.1, -0.4, 1.2}), {1.0, -0.5, 1.8}};
  const UnevenTurning turning{
      0.0, 0.05, {Eigen::Quaterniond::Identity(), exp_so3({0.03, 0.01, -0.02}), exp_so3({})}};
  PointCloud cloud;
  for (int i = 0; i < 5; ++i) {
    cloud.points.push_back({5.0F, static_cast<float>(i), 1.0F, 0.5F});
    cloud.times.push_back(0.02F * static_cast<float>(i));
  }
  FrontEndResult result;
  const PointCloud kept = corrected_cloud(cloud, turning, T_base_lidar, result);
  result.correction.undo_gyro = true;
  const PointCloud undone = corrected_cloud(cloud, turning, T_base_lidar, result);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p_lidar = cloud.points[i].position().cast<double>();
    EXPECT_TRUE(test::near(kept.points[i].position().cast<double>(), T_base_lidar * p_lidar, 1e-5));
    const Eigen::Quaterniond then = turning.at(static_cast<double>(cloud.times[i])).conjugate();
    EXPECT_TRUE(test::near(undone.points[i].position().cast<double>(),
                           T_base_lidar.translation + then * (T_base_lidar.rotation * p_lidar),
                           1e-5))
        << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::front_end
