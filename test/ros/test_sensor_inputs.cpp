// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <topic_tools/shape_shifter.h>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/recording_check.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kStamp = 1317384506123456789;

std_msgs::Header header() { return header_of(kStamp, "sensor"); }

geometry_msgs::Twist twist() {
  geometry_msgs::Twist twist;
  twist.linear.x = 7.5;
  twist.angular.z = -0.25;
  return twist;
}

geometry_msgs::TwistStamped twist_stamped() {
  geometry_msgs::TwistStamped message;
  message.header = header();
  message.twist = twist();
  return message;
}

geometry_msgs::TwistWithCovarianceStamped twist_with_covariance() {
  geometry_msgs::TwistWithCovarianceStamped message;
  message.header = header();
  message.twist.twist = twist();
  return message;
}

nav_msgs::Odometry odometry() {
  nav_msgs::Odometry message;
  message.header = header();
  message.header.frame_id = "odom";
  message.child_frame_id = "sensor";
  message.twist.twist = twist();
  return message;
}

GeoPointStamped geo_point() { return {header(), 49.01, 8.43, 115.5}; }

const char* const kGga = "$GPGGA,123519,4900.600,N,00825.800,E,1,08,0.9,70.0,M,45.5,M,,";

NmeaSentence sentence(const std::string& text) { return {header(), text}; }

sensor_msgs::NavSatFix nav_sat_fix() {
  sensor_msgs::NavSatFix message;
  message.header = header();
  message.latitude = 49.01;
  message.longitude = 8.43;
  message.altitude = 115.5;
  return message;
}

/// As it comes from a publisher of any type.
template <typename Message>
topic_tools::ShapeShifter as_received(const Message& message) {
  namespace traits = ros::message_traits;
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(out, message);
  topic_tools::ShapeShifter any;
  any.morph(traits::md5sum(message), traits::datatype(message), traits::definition(message), "");
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  any.read(in);
  return any;
}

void expect_the_velocity(const std::optional<SensorInput<VelocitySample>>& input) {
  ASSERT_TRUE(input);
  EXPECT_EQ(input->sample.stamp, kStamp);
  EXPECT_EQ(input->frame_id, "sensor");
  EXPECT_TRUE(input->sample.linear.isApprox(Eigen::Vector3d(7.5, 0.0, 0.0)));
  EXPECT_TRUE(input->sample.angular.isApprox(Eigen::Vector3d(0.0, 0.0, -0.25)));
}

void expect_the_fix(const std::optional<SensorInput<GnssFix>>& input) {
  ASSERT_TRUE(input);
  EXPECT_EQ(input->sample.stamp, kStamp);
  EXPECT_EQ(input->frame_id, "sensor");
  EXPECT_EQ(input->sample.latitude_deg, 49.01);
  EXPECT_EQ(input->sample.longitude_deg, 8.43);
  EXPECT_EQ(input->sample.altitude_m, 115.5);
  EXPECT_GE(input->sample.status, 0);
  EXPECT_FALSE(input->sample.covariance);
}

constexpr auto velocity_of = [](const BagMessage& message) {
  return VelocityMessages::read(message);
};
constexpr auto fix_of = [](const BagMessage& message) { return GnssMessages::read(message); };

class SensorInputs : public testing::Test {
 protected:
  SensorInputs() : bag_((folder_.path() / "drive.bag").string(), rosbag::bagmode::Write) {}

  template <typename Message>
  void record(const std::string& topic, const Message& message) {
    bag_.write(topic, to_ros(kStamp), message);
  }
  /// The first message of a topic, by `read`; nothing more is recorded from here on.
  template <typename Read>
  auto recorded(const std::string& topic, const Read& read) {
    BagStream messages = bags().messages_of({topic});
    return read(*messages.next());
  }
  SensorTopics topics() { return topics_in(bags()); }
  static std::vector<preprocessing::CheckDiagnostic> gnss_diagnostics(const BagSet& drive) {
    RecordingCheck recording;
    recording.bags = &drive;
    recording.topics = topics_in(drive);
    return check(recording, {}).back().diagnostics;
  }
  BagSet bags() {
    bag_.close();
    return BagSet({(folder_.path() / "drive.bag").string()});
  }

  const test::TemporaryFolder folder_;
  rosbag::Bag bag_;
};

TEST_F(SensorInputs, AreReadFromEveryTypeThatABagHolds) {
  record("/a", twist_stamped());
  record("/b", twist_with_covariance());
  record("/c", odometry());
  record("/d", nav_sat_fix());
  record("/e", geo_point());
  record("/f", header());
  for (const char* topic : {"/a", "/b", "/c"}) {
    SCOPED_TRACE(topic);
    expect_the_velocity(recorded(topic, velocity_of));
    EXPECT_FALSE(recorded(topic, fix_of));
  }
  for (const char* topic : {"/d", "/e"}) {
    SCOPED_TRACE(topic);
    expect_the_fix(recorded(topic, fix_of));
    EXPECT_FALSE(recorded(topic, velocity_of));
  }
  EXPECT_FALSE(recorded("/f", velocity_of));
  EXPECT_FALSE(recorded("/f", fix_of));
}

TEST(SensorInputsReceived, AreReadFromEveryType) {
  expect_the_velocity(VelocityMessages::read(as_received(twist_stamped())));
  expect_the_velocity(VelocityMessages::read(as_received(twist_with_covariance())));
  expect_the_velocity(VelocityMessages::read(as_received(odometry())));
  expect_the_fix(GnssMessages::read(as_received(nav_sat_fix())));
  expect_the_fix(GnssMessages::read(as_received(geo_point())));
  EXPECT_FALSE(GnssMessages::read(as_received(odometry())));
}

TEST_F(SensorInputs, FixesAreFoundAsGeoPointsWhereThereIsNothingBetter) {
  record("/gps/geopoint", geo_point());
  EXPECT_EQ(topics().gnss, "/gps/geopoint");
}

TEST_F(SensorInputs, FixesWithACovarianceArePreferred) {
  for (int i = 0; i < 3; ++i) record("/gps/geopoint", geo_point());
  record("/fix", nav_sat_fix());
  EXPECT_EQ(topics().gnss, "/fix");
}

TEST_F(SensorInputs, FixesAreReadFromTheSentencesOfAReceiver) {
  record("/nmea_sentence", sentence("$GPRMC,123519,A,4900.600,N,00825.800,E,0,0,230394,,"));
  record("/nmea_sentence", sentence(kGga));
  EXPECT_EQ(topics().gnss, "/nmea_sentence");
  const BagSet there = bags();
  BagStream messages = there.messages_of({"/nmea_sentence"});
  const auto other = messages.next();
  ASSERT_TRUE(other);
  EXPECT_FALSE(GnssMessages::read(*other)) << "only some sentences hold a fix";
  EXPECT_TRUE(contains(GnssMessages::types(), other->getDataType()));
  const auto message = messages.next();
  ASSERT_TRUE(message);
  const auto fix = GnssMessages::read(*message);
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->sample.stamp, kStamp);
  EXPECT_EQ(fix->frame_id, "sensor");
  EXPECT_NEAR(fix->sample.latitude_deg, 49.01, 1e-9);
  EXPECT_NEAR(fix->sample.altitude_m, 115.5, 1e-9);
  EXPECT_TRUE(GnssMessages::read(as_received(sentence(kGga))));
  for (const auto& diagnostic : gnss_diagnostics(there)) {
    EXPECT_EQ(diagnostic.text.find("not NavSatFix"), std::string::npos) << diagnostic.text;
  }
}

TEST_F(SensorInputs, AReceiverThatSendsRmcAloneIsReported) {
  for (int i = 0; i < 60; ++i) {
    record("/nmea_sentence", sentence("$GPRMC,123519,A,4900.600,N,00825.800,E,0,0,230394,,"));
  }
  const auto diagnostics = gnss_diagnostics(bags());
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(), [](const auto& diagnostic) {
    return diagnostic.text.find("no GGA among") != std::string::npos;
  }));
}

/// Such as a velocity in East-North-Up, or an odometry whose twist is empty.
TEST_F(SensorInputs, WhatMayHoldSomethingElseIsNotTakenForAVelocityUnasked) {
  record("/fix_velocity", twist_with_covariance());
  record("/odom", odometry());
  EXPECT_EQ(topics().velocity, "");
}

}  // namespace
}  // namespace lidar_mapping::ros_border
