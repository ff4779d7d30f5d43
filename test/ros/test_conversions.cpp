// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "near.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kStamp = 1317384506123456789;

Pose some_pose() { return {exp_so3({0.1, -0.2, 2.9}), Eigen::Vector3d(12.5, -3.25, 0.75)}; }

Covariance6 some_covariance() {
  Covariance6 root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = 0.01 * ((i * 7) % 11);
  return root * root.transpose() + Covariance6::Identity();
}

PointCloudPtr some_cloud() {
  auto cloud = std::make_shared<PointCloud>();
  cloud->points = {{1.0F, 2.0F, 3.0F, 0.5F}, {-4.0F, 5.5F, 6.0F, 255.0F}};
  return cloud;
}

void expect_same(const Pose& a, const Pose& b) { EXPECT_TRUE(test::near(a, b, 1e-12)); }

void expect_same(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.points[i].position(), b.points[i].position());
    EXPECT_EQ(a.points[i].intensity, b.points[i].intensity);
  }
  EXPECT_EQ(a.times, b.times);
}

// Stamps went through a 32-bit float and lost up to 64 s.
TEST(StampConversion, IsExactToTheNanosecond) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<Stamp> stamps(0, 4294967295999999999);
  EXPECT_EQ(from_ros(to_ros(kStamp)), kStamp);
  EXPECT_EQ(to_ros(kStamp).nsec, 123456789U);
  for (int i = 0; i < 1000; ++i) {
    const Stamp stamp = stamps(random);
    ASSERT_EQ(from_ros(to_ros(stamp)), stamp);
  }
}

TEST(StampConversion, RefusesWhatRosCannotHold) {
  EXPECT_THROW(to_ros(-1), InputError);
  EXPECT_THROW(to_ros(4294967296000000000), InputError);
}

TEST(PoseConversion, ComesBackTheSame) {
  expect_same(from_message(to_message(some_pose())), some_pose());
  expect_same(from_message(to_transform(some_pose())), some_pose());
}

// Two maps of one drive differed by a point, as each message turned its poses by a last digit.
TEST(PoseConversion, KeepsEveryBitOfARotation) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  Pose pose;
  for (int i = 0; i < 1000; ++i) {
    Vector6d step;
    for (int k = 0; k < 6; ++k) step[k] = normal(random);
    pose = perturbed(pose, step);
    const Pose sent = from_message(to_message(pose));
    ASSERT_EQ(sent.rotation.coeffs(), pose.rotation.coeffs()) << i;
    ASSERT_EQ(sent.translation, pose.translation) << i;
  }
}

TEST(PoseConversion, RefusesWhatIsNoPose) {
  geometry_msgs::Pose zero_quaternion;
  EXPECT_THROW(from_message(zero_quaternion), InputError);
  geometry_msgs::Pose not_finite = to_message(some_pose());
  not_finite.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(from_message(not_finite), InputError);
}

TEST(CovarianceConversion, IsRowMajorTranslationFirst) {
  Covariance6 covariance = Covariance6::Identity();
  covariance(0, 5) = covariance(5, 0) = 0.5;
  covariance(3, 3) = 7.0;
  const CovarianceArray values = to_array(covariance);
  EXPECT_EQ(values[5], 0.5);
  EXPECT_EQ(values[21], 7.0);
  EXPECT_EQ(from_array(values), covariance);
}

TEST(FrameName, DropsTheLeadingSlash) {
  EXPECT_EQ(frame_name("/velo_link"), "velo_link");
  EXPECT_EQ(frame_name("velo_link"), "velo_link");
  EXPECT_EQ(frame_name("/"), "");
}

TEST(CloudConversion, KeepsPointsIntensityAndTimes) {
  PointCloud cloud = *some_cloud();
  expect_same(from_message(to_message(cloud, kStamp, "base_link")), cloud);
  cloud.times = {-0.05F, 0.0499F};
  const sensor_msgs::PointCloud2 message = to_message(cloud, kStamp, "base_link");
  expect_same(from_message(message), cloud);
  EXPECT_EQ(from_ros(message.header.stamp), kStamp);
  EXPECT_EQ(message.header.frame_id, "base_link");
}

std::vector<std::uint8_t> sent(const ros::SerializedMessage& message) {
  return {message.buf.get(), message.buf.get() + message.num_bytes};
}

TEST(CloudConversion, SendsTheSameBytesFromWhereThePointsLie) {
  using ros::serialization::serializeMessage;
  PointCloud with_times = *some_cloud();
  with_times.times = {-0.05F, 0.0499F};
  for (const PointCloud& cloud : {PointCloud(), *some_cloud(), with_times}) {
    EXPECT_EQ(sent(serializeMessage(OutgoingCloud(cloud, kStamp, "base_link"))),
              sent(serializeMessage(to_message(cloud, kStamp, "base_link"))));
  }
  EXPECT_STREQ(ros::message_traits::md5sum<OutgoingCloud>(),
               ros::message_traits::md5sum<sensor_msgs::PointCloud2>());
  EXPECT_STREQ(ros::message_traits::datatype<OutgoingCloud>(), "sensor_msgs/PointCloud2");
}

TEST(CloudConversion, RefusesMorePointsThanAMessageHolds) {
  EXPECT_NO_THROW(check_cloud_size(0, 16));
  EXPECT_NO_THROW(check_cloud_size(62'000'000, 16));
  EXPECT_THROW(check_cloud_size(62'500'000, 16), InputError) << "1 GB is for the whole message";
  EXPECT_THROW(check_cloud_size(50'000'000, 20), InputError);
  EXPECT_THROW(check_cloud_size((std::size_t{1} << 32U) + 1, 16), InputError) << "1 in 32 bits";
}

// Empty and all-NaN sweeps.
TEST(CloudConversion, LeavesOutPointsThatAreNotFinite) {
  PointCloud cloud = *some_cloud();
  cloud.points[0].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(from_message(to_message(cloud, kStamp, "base_link")).size(), 1U);
  cloud.points[1].x = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(from_message(to_message(cloud, kStamp, "base_link")).empty());
  EXPECT_TRUE(from_message(sensor_msgs::PointCloud2()).empty());
}

TEST(CloudConversion, ReadsOrganisedCloudsWithPaddedRows) {
  sensor_msgs::PointCloud2 message = to_message(*some_cloud(), kStamp, "base_link");
  message.width = 1;
  message.height = 2;
  message.row_step = 24;
  message.data.insert(message.data.begin() + 16, 8, 0);
  expect_same(from_message(message), *some_cloud());
}

TEST(CloudConversion, RefusesTruncatedOrForeignData) {
  sensor_msgs::PointCloud2 truncated = to_message(*some_cloud(), kStamp, "base_link");
  truncated.data.pop_back();
  EXPECT_THROW(from_message(truncated), InputError);
  sensor_msgs::PointCloud2 doubles = to_message(*some_cloud(), kStamp, "base_link");
  doubles.fields[0].datatype = sensor_msgs::PointField::FLOAT64;
  EXPECT_THROW(from_message(doubles), InputError);
  sensor_msgs::PointCloud2 flat = to_message(*some_cloud(), kStamp, "base_link");
  flat.fields.erase(flat.fields.begin() + 2);
  EXPECT_THROW(from_message(flat), InputError);
}

TEST(KeyFrameConversion, ComesBackTheSame) {
  const KeyFrame key_frame{
      17,   2,           kStamp, some_pose(), some_covariance(), {Eigen::Vector3d::UnitX()},
      true, some_cloud()};
  const KeyFrameMessage message = to_message(key_frame, "run", "base_link");
  const KeyFrame again = from_message(message);
  EXPECT_EQ(message.run_id, "run");
  EXPECT_EQ(again.index, 17U);
  EXPECT_EQ(again.segment, 2U);
  EXPECT_EQ(again.stamp, kStamp);
  expect_same(again.T_odom_base, some_pose());
  EXPECT_TRUE(test::near(again.motion_covariance, some_covariance(), 1e-12));
  ASSERT_EQ(again.degenerate_directions.size(), 1U);
  EXPECT_EQ(again.degenerate_directions[0], Eigen::Vector3d::UnitX());
  EXPECT_TRUE(again.doubtful);
  expect_same(*again.cloud, *some_cloud());
}

TEST(KeyFrameConversion, LeavesTheCloudNullWhereThereIsNone) {
  KeyFrame key_frame;
  EXPECT_EQ(from_message(to_message(key_frame, "run", "base_link")).cloud, nullptr);
  EXPECT_FALSE(from_message(to_message(key_frame, "run", "base_link")).doubtful);
}

TEST(KeyFrameConversion, KeepsThePlaceOfTheLidarAndThatItIsNotKnown) {
  const Eigen::Vector3d p_base_lidar(0.5, -0.25, 1.73);
  EXPECT_EQ(received(to_message(KeyFrame(), "run", "base_link", p_base_lidar)).p_base_lidar,
            p_base_lidar);
  EXPECT_FALSE(received(to_message(KeyFrame(), "run", "base_link")).p_base_lidar);
}

TEST(KeyFrameConversion, RefusesACovarianceThatIsNotFinite) {
  KeyFrameMessage message = to_message(KeyFrame(), "run", "base_link");
  message.motion_covariance[7] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(from_message(message), InputError);
}

// Stamps and indices of optimised key frames were lost.
TEST(KeyFramePosesConversion, ComesBackTheSame) {
  const KeyFramePoses poses{5, false, {{3, kStamp, some_pose()}, {9, kStamp + 1, Pose()}}, 4};
  const KeyFramePosesMessage message = to_message(poses, "run", "map");
  const KeyFramePoses again = from_message(message);
  EXPECT_EQ(from_ros(message.header.stamp), kStamp + 1);
  EXPECT_EQ(again.revision, 5U);
  EXPECT_EQ(again.since, 4U);
  EXPECT_FALSE(again.whole);
  ASSERT_EQ(again.poses.size(), 2U);
  EXPECT_EQ(again.poses[0].index, 3U);
  EXPECT_EQ(again.poses[1].stamp, kStamp + 1);
  expect_same(again.poses[0].T_map_base, some_pose());
}

TEST(KeyFramePosesConversion, RefusesListsOfDifferentLength) {
  KeyFramePosesMessage message = to_message(KeyFramePoses(), "run", "map");
  message.indices.push_back(1);
  EXPECT_THROW(from_message(message), InputError);
}

TEST(LoopConversion, ComesBackTheSame) {
  const Loop loop{
      3, 90, kStamp, some_pose(), some_covariance(), 0.01, 0.8, LoopSource::kAppearance};
  const Loop again = from_message(to_message(loop, "run", "base_link"));
  EXPECT_EQ(again.from, 3U);
  EXPECT_EQ(again.to, 90U);
  EXPECT_EQ(again.stamp, kStamp);
  expect_same(again.T_from_to, some_pose());
  EXPECT_TRUE(test::near(again.covariance, some_covariance(), 1e-12));
  EXPECT_EQ(again.fitness, 0.01);
  EXPECT_EQ(again.overlap, 0.8);
  EXPECT_EQ(again.source, LoopSource::kAppearance);
}

TEST(LoopVerdictConversion, ComesBackTheSame) {
  const LoopVerdict verdict{
      3,   90,  kStamp, LoopSource::kGnss, Verdict::kRefused, "overlap 0.2", 7.0, 0.4, 0.2,
      0.1, 0.3, 12.0};
  const LoopVerdict again = from_message(to_message(verdict, "run", "base_link"));
  EXPECT_EQ(again.stamp, kStamp);
  EXPECT_EQ(again.source, LoopSource::kGnss);
  EXPECT_EQ(again.verdict, Verdict::kRefused);
  EXPECT_EQ(again.reason, "overlap 0.2");
  EXPECT_EQ(again.distance, 7.0);
  EXPECT_EQ(again.free_space_violation, 0.1);
  EXPECT_EQ(again.horizontal_eigenvalue, 0.3);
  EXPECT_EQ(again.innovation, 12.0);
}

TEST(FloorConversion, ComesBackTheSame) {
  Floor floor;
  floor.stamp = kStamp;
  floor.found = true;
  floor.normal = Eigen::Vector3d(0.0, 0.6, 0.8);
  floor.offset = 1.7;
  floor.covariance = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
  floor.inliers = 812;
  const Floor again = from_message(to_message(floor, "base_link"));
  EXPECT_EQ(again.stamp, kStamp);
  EXPECT_TRUE(again.found);
  EXPECT_EQ(again.normal, floor.normal);
  EXPECT_EQ(again.offset, 1.7);
  EXPECT_EQ(again.covariance, floor.covariance);
  EXPECT_EQ(again.inliers, 812);
}

TEST(ImuConversion, KeepsWhetherThereIsAnOrientation) {
  ImuSample sample{kStamp, {0.1, 0.2, 0.3}, {0.0, 0.0, 9.81}, std::nullopt};
  EXPECT_FALSE(from_message(to_message(sample, "base_link")).orientation);
  sample.orientation = exp_so3({0.0, 0.0, 1.0});
  const ImuSample again = from_message(to_message(sample, "base_link"));
  EXPECT_EQ(again.stamp, kStamp);
  EXPECT_EQ(again.angular_velocity, sample.angular_velocity);
  EXPECT_EQ(again.linear_acceleration, sample.linear_acceleration);
  ASSERT_TRUE(again.orientation);
  EXPECT_NEAR(again.orientation->angularDistance(*sample.orientation), 0.0, 1e-12);
}

TEST(ImuConversion, TakesAQuaternionWithoutLengthForNone) {
  EXPECT_FALSE(from_message(sensor_msgs::Imu()).orientation);
}

TEST(ImuConversion, TakesACovarianceOfMinusOneForNoValue) {
  sensor_msgs::Imu message;
  message.angular_velocity.z = 5.0;
  message.linear_acceleration.x = std::numeric_limits<double>::quiet_NaN();
  message.orientation.w = 1.0;
  EXPECT_TRUE(from_message(message).has_angular_velocity);
  EXPECT_TRUE(from_message(message).has_linear_acceleration);
  message.angular_velocity_covariance[0] = message.linear_acceleration_covariance[0] =
      message.orientation_covariance[0] = -1.0;
  const ImuSample sample = from_message(message);
  EXPECT_FALSE(sample.has_angular_velocity || sample.has_linear_acceleration || sample.orientation);
  EXPECT_TRUE(sample.angular_velocity.isZero(0.0) && sample.linear_acceleration.isZero(0.0));
  const sensor_msgs::Imu again = to_message(sample, "base_link");
  EXPECT_EQ(again.angular_velocity_covariance[0], -1.0);
  EXPECT_EQ(again.linear_acceleration_covariance[0], -1.0);
}

// The nodes and map_bag make the same of it to the bit.
TEST(SyncedInputsConversion, BringsTheUnevenTurningBackBitForBit) {
  SyncedInputsMessage message;
  EXPECT_FALSE(uneven_turning_of(message));
  const UnevenTurning turning{
      -0.0521, 0.002, {exp_so3({0.1, 0.3, -0.2}), exp_so3({1e-9, 0.0, 0.0})}};
  fill(message, turning);
  const auto again = uneven_turning_of(message);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->begin, turning.begin);
  EXPECT_EQ(again->step, turning.step);
  ASSERT_EQ(again->R_stamp_knot.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again->R_stamp_knot[i].coeffs(), turning.R_stamp_knot[i].coeffs());
  }
}

TEST(SyncedInputsConversion, BringsTheFingerprintOfTheDriversPointsBack) {
  SyncedInputsMessage message;
  EXPECT_FALSE(fingerprint_of(message));
  message.fingerprint = 0xfedcba9876543210;
  EXPECT_EQ(fingerprint_of(message), 0xfedcba9876543210);
}

TEST(SyncedInputsConversion, BringsTheFeltForceBackBitForBit) {
  SyncedInputsMessage message;
  EXPECT_FALSE(felt_force_of(message));
  const FeltForce felt{kStamp, {0.1, -0.2, 9.83}, {1.0, 0.5, 0.1}};
  fill(message, felt);
  const auto again = felt_force_of(message);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->since, felt.since);
  EXPECT_EQ(again->mean, felt.mean);
  EXPECT_EQ(again->p_base_imu, felt.p_base_imu);
}

TEST(VelocityConversion, ComesBackTheSame) {
  const VelocitySample sample{kStamp, {10.0, 0.1, 0.0}, {0.0, 0.0, 0.2}};
  const VelocitySample again = from_message(to_message(sample, "base_link"));
  EXPECT_EQ(again.stamp, kStamp);
  EXPECT_EQ(again.linear, sample.linear);
  EXPECT_EQ(again.angular, sample.angular);
}

TEST(NavSatFixConversion, HasACovarianceOnlyWhereItsTypeIsKnown) {
  sensor_msgs::NavSatFix message;
  message.header.stamp = to_ros(kStamp);
  message.latitude = 49.0;
  message.status.status = 2;
  message.position_covariance[4] = 0.25;
  EXPECT_FALSE(from_message(message).covariance);
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_KNOWN;
  const GnssFix fix = from_message(message);
  EXPECT_EQ(fix.stamp, kStamp);
  EXPECT_EQ(fix.latitude_deg, 49.0);
  EXPECT_EQ(fix.status, 2);
  EXPECT_EQ((*fix.covariance)(1, 1), 0.25);
}

TEST(GnssConversion, ComesBackWithTheLeverArm) {
  GnssPosition position;
  position.stamp = kStamp;
  position.p_enu_antenna = {100.0, -20.0, 3.0};
  position.covariance = Eigen::Vector3d(0.01, 0.02, 0.09).asDiagonal();
  position.R_enu_base = exp_so3({0.0, 0.0, 0.7});
  const Eigen::Vector3d lever(0.5, 0.0, 1.2);
  const nav_msgs::Odometry message = to_message(position, "map", "gps");
  EXPECT_EQ(message.child_frame_id, "gps");
  const GnssPosition again = from_message(message, lever);
  EXPECT_EQ(again.stamp, kStamp);
  EXPECT_EQ(again.p_enu_antenna, position.p_enu_antenna);
  EXPECT_EQ(again.covariance, position.covariance);
  EXPECT_EQ(again.p_base_antenna, lever);
  EXPECT_NEAR(again.R_enu_base->angularDistance(*position.R_enu_base), 0.0, 1e-12);
}

TEST(GnssConversion, SaysWhenTheOrientationIsUnknown) {
  const nav_msgs::Odometry message = to_message(GnssPosition(), "map", "gps");
  EXPECT_EQ(message.pose.covariance[21], -1.0);
  EXPECT_FALSE(from_message(message, Eigen::Vector3d::Zero()).R_enu_base);
}

// Odometry without covariance and twist.
TEST(OdometryConversion, TurnsTheCovarianceIntoTheAxesOfOdom) {
  front_end::FrontEndResult result;
  result.stamp = kStamp;
  result.T_odom_base = {exp_so3({0.0, 0.0, M_PI / 2}), Eigen::Vector3d(5.0, 0.0, 0.0)};
  result.twist << 10.0, 0.0, 0.0, 0.0, 0.0, 0.1;
  result.covariance = 1e-4 * Covariance6::Identity();
  Covariance6 forward = 1e-6 * Covariance6::Identity();
  forward(0, 0) = 4.0;  // along the vehicle's x, which is y of odom here
  const nav_msgs::Odometry message = to_odometry(result, forward, 0.1, "odom", "base_link");
  EXPECT_EQ(from_ros(message.header.stamp), kStamp);
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_NEAR(message.pose.covariance[7], 4.0, 1e-9);
  EXPECT_NEAR(message.pose.covariance[0], 0.0, 1e-3);
  EXPECT_EQ(message.twist.twist.linear.x, 10.0);
  EXPECT_EQ(message.twist.twist.angular.z, 0.1);
  EXPECT_NEAR(message.twist.covariance[0], 1e-2, 1e-12);
}

TEST(StatusConversion, SaysWhatBecameOfTheScan) {
  front_end::FrontEndResult result;
  result.stamp = kStamp;
  result.status.state = front_end::TrackingState::kDegraded;
  result.status.overlap = 0.4;
  result.status.probability = 0.7;
  result.status.repeated = true;
  result.status.converged = true;
  result.status.iterations = 12;
  result.status.fitness = 0.03;
  result.status.inlier_fraction = 0.6;
  result.status.degenerate_directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  result.status.rescued = true;
  result.status.elevation_shift = 0.004;
  result.status.unobserved_stddev = 1.25;
  result.status.stamp_jitter = 0.015;
  result.status.sweep_times.source = front_end::SweepTimes::kNegated;
  result.status.gyro_distrusted = true;
  result.status.velocity_distrusted = true;
  result.status.vertical_ride_distance = -2.5;
  result.status.seconds = 0.05;
  result.status.step_seconds = {{"match", 0.02}, {"map", 0.01}};
  result.key_frame = KeyFrame();
  result.key_frame->index = 8;
  const FrontEndStatusMessage message = to_message(result, 3, "base_link");
  EXPECT_EQ(from_ros(message.header.stamp), kStamp);
  EXPECT_EQ(message.state, "degraded");
  EXPECT_EQ(message.overlap, 0.4);
  EXPECT_EQ(message.probability, 0.7);
  EXPECT_TRUE(message.repeated);
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_TRUE(message.converged);
  EXPECT_EQ(message.iterations, 12U);
  EXPECT_EQ(message.fitness, 0.03);
  EXPECT_EQ(message.inlier_fraction, 0.6);
  ASSERT_EQ(message.degenerate_directions.size(), 2U);
  EXPECT_EQ(message.degenerate_directions[0].x, 1.0);
  EXPECT_EQ(message.degenerate_directions[1].z, 1.0);
  EXPECT_TRUE(message.rescued);
  EXPECT_EQ(message.elevation_shift, 0.004);
  EXPECT_EQ(message.unobserved_stddev, 1.25);
  EXPECT_EQ(message.stamp_jitter, 0.015);
  EXPECT_EQ(message.sweep_times, "negated");
  EXPECT_TRUE(message.gyro_distrusted);
  EXPECT_TRUE(message.velocity_distrusted);
  EXPECT_EQ(message.vertical_ride_distance, -2.5);
  EXPECT_EQ(message.seconds, 0.05);
  EXPECT_TRUE(message.key_frame);
  EXPECT_EQ(message.key_frame_index, 8U);
  EXPECT_EQ(message.scans_dropped, 3U);
  EXPECT_EQ(message.step_names.at(0), "match");
  EXPECT_EQ(message.step_seconds.at(0), 0.02);
  EXPECT_EQ(message.step_names.at(1), "map");
  EXPECT_EQ(message.step_seconds.at(1), 0.01);
  result.key_frame.reset();
  result.status.rescued = result.status.converged = false;
  const FrontEndStatusMessage plain = to_message(result, 0, "base_link");
  EXPECT_FALSE(plain.key_frame || plain.rescued || plain.converged);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
