// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/ouster_packets.hpp"

#include "near.hpp"
#include "ouster_encoder.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::near;
using test::OusterReturn;
using test::OusterSensor;

OusterSensor sensor_of(const std::string& profile) {
  OusterSensor sensor;
  sensor.profile = profile;
  sensor.columns = 512;
  sensor.columns_per_packet = 16;
  sensor.altitudes_deg = {20.0, 5.5, -0.25, -18.0};
  sensor.azimuths_deg = {3.1, 1.0, -1.1, -3.2};
  return sensor;
}

OusterFormat format_of(const OusterSensor& sensor) {
  OusterFormat format;
  format.profile = ouster_profile(sensor.profile);
  format.pixels_per_column = sensor.pixels();
  format.columns_per_packet = sensor.columns_per_packet;
  format.columns_per_frame = sensor.columns;
  format.last_column = sensor.columns - 1;
  for (const double angle : sensor.altitudes_deg) format.altitudes.push_back(kRadPerDeg * angle);
  for (const double angle : sensor.azimuths_deg) format.azimuths.push_back(kRadPerDeg * angle);
  format.origin_to_beam = 1e-3 * sensor.origin_to_beam_mm;
  return format;
}

OusterReturn measured(std::size_t column, std::size_t pixel) {
  if (pixel == 1 && column % 2 == 0) return {};
  return {static_cast<std::uint32_t>(2000 + 10 * column + pixel), static_cast<std::uint8_t>(pixel)};
}

constexpr std::uint64_t kBegin = 5'000'000'000, kStep = 195'312;

std::vector<std::uint8_t> packet_of(const OusterSensor& sensor) {
  return test::ouster_packet(sensor, 77, 128, kBegin, kStep, measured);
}

class OusterProfiles : public ::testing::TestWithParam<const char*> {};

TEST_P(OusterProfiles, PointsLieWhereTheManualHasThem) {
  const OusterSensor sensor = sensor_of(GetParam());
  const OusterDecoder decoder(format_of(sensor));
  const auto packet = packet_of(sensor);
  ASSERT_EQ(decoder.packet_size(), packet.size());
  EXPECT_EQ(decoder.frame(packet.data()), 77);
  EXPECT_EQ(decoder.last_stamp(packet.data()), static_cast<Stamp>(kBegin + 15 * kStep));
  EXPECT_TRUE(decoder.has_column(packet.data(), 128));
  EXPECT_TRUE(decoder.has_column(packet.data(), 143));
  EXPECT_FALSE(decoder.has_column(packet.data(), 144));
  std::vector<OusterPoint> points;
  decoder.decode(packet.data(), points);
  ASSERT_EQ(points.size(), 16U * 4U - 8U);
  std::size_t at = 0;
  for (std::size_t column = 128; column < 144; ++column) {
    for (std::size_t pixel = 0; pixel < 4; ++pixel) {
      const OusterReturn value = measured(column, pixel);
      if (value.counts == 0) continue;
      const OusterPoint& point = points[at++];
      const Eigen::Vector3d expected = sensor.point(column, pixel, value.counts);
      EXPECT_TRUE(near(point.point.position().cast<double>(), expected, 1e-6));
      EXPECT_EQ(point.point.intensity, static_cast<float>(pixel));
      EXPECT_EQ(point.stamp, static_cast<Stamp>(kBegin + (column - 128) * kStep));
    }
  }
}

TEST_P(OusterProfiles, InvalidColumnsAreLeftOut) {
  const OusterSensor sensor = sensor_of(GetParam());
  const OusterDecoder decoder(format_of(sensor));
  const std::size_t whole = 16 * 4 - 8, of_column = 4 - 1;
  const auto points_with = [&](std::size_t at, std::uint16_t number) {
    auto packet = packet_of(sensor);
    test::put_at(packet, at, number);
    std::vector<OusterPoint> points;
    decoder.decode(packet.data(), points);
    return points.size();
  };
  const std::size_t column = sensor.column_at(2);
  EXPECT_EQ(points_with(column + 8, 512), whole - of_column);  // no such column
  const std::size_t status = sensor.is_legacy() ? column + sensor.column_size() - 4 : column + 10;
  EXPECT_EQ(points_with(status, 0), whole - of_column);
  EXPECT_EQ(points_with(column + 6, 0xFFFF), whole - of_column);  // its time
}

INSTANTIATE_TEST_SUITE_P(All, OusterProfiles,
                         ::testing::Values("LEGACY", "RNG19_RFL8_SIG16_NIR16",
                                           "RNG19_RFL8_SIG16_NIR16_DUAL"));

/// The numbers of bytes in the manual for 64 pixels and 16 columns in a packet.
TEST(Ouster, PacketsHaveTheSizeOfTheManual) {
  const auto size = [](OusterProfile profile) {
    OusterFormat format;
    format.profile = profile;
    format.pixels_per_column = 64;
    format.columns_per_packet = 16;
    format.columns_per_frame = 1024;
    format.altitudes.resize(64);
    format.azimuths.resize(64);
    return OusterDecoder(format).packet_size();
  };
  EXPECT_EQ(size(OusterProfile::kLegacy), 12608U);
  EXPECT_EQ(size(OusterProfile::kSingle), 12544U);
  EXPECT_EQ(size(OusterProfile::kDualReturns), 16640U);
}

TEST(Ouster, TwoReturnsAreTwoPointsUnlessTheyAreEqual) {
  const OusterSensor sensor = sensor_of("RNG19_RFL8_SIG16_NIR16_DUAL");
  const OusterDecoder decoder(format_of(sensor));
  auto packet = packet_of(sensor);
  const auto put_second = [&](std::size_t pixel, std::uint32_t counts) {
    test::put_at(packet, sensor.column_at(1) + 12 + 16 * pixel + 4, counts);
    packet[sensor.column_at(1) + 12 + 16 * pixel + 7] = 200;
  };
  put_second(0, 7000);
  put_second(2, measured(129, 2).counts);
  std::vector<OusterPoint> points;
  decoder.decode(packet.data(), points);
  ASSERT_EQ(points.size(), 16U * 4U - 8U + 1U);
  const std::size_t second = 3 + 1;  // behind the three of the first column
  EXPECT_TRUE(
      near(points[second].point.position().cast<double>(), sensor.point(129, 0, 7000), 1e-6));
  EXPECT_EQ(points[second].point.intensity, 200.0F);
}

TEST(Ouster, BeamsThatBeginAboveTheOrigin) {
  OusterSensor sensor = sensor_of("LEGACY");
  sensor.origin_to_beam_mm = 0.0;
  OusterFormat format = format_of(sensor);
  format.origin_to_beam = 0.03;
  format.beam_height = 0.04;
  std::vector<OusterPoint> points;
  OusterDecoder(format).decode(packet_of(sensor).data(), points);
  const double angle = -2.0 * kPi * 128.0 / 512.0;
  const Eigen::Vector3d start(0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.04);
  const Eigen::Vector3d expected = start + sensor.point(128, 0, measured(128, 0).counts - 50.0);
  EXPECT_TRUE(near(points[0].point.position().cast<double>(), expected, 1e-6));
}

TEST(Ouster, OtherProfilesAreNamed) {
  try {
    ouster_profile("FIVE_WORD_PIXEL");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("packets of the profile FIVE_WORD_PIXEL are not read"),
              std::string::npos);
  }
}

TEST(Ouster, NumbersThatDoNotFitAreNamed) {
  OusterFormat format = format_of(sensor_of("LEGACY"));
  format.altitudes.pop_back();
  EXPECT_THROW(OusterDecoder{format}, InputError);
  format = format_of(sensor_of("LEGACY"));
  format.columns_per_frame = 0;
  EXPECT_THROW(OusterDecoder{format}, InputError);
  format = format_of(sensor_of("LEGACY"));
  format.azimuths[0] = std::nan("");
  EXPECT_THROW(OusterDecoder{format}, InputError);
}

TEST(Ouster, ImuInMetresAndRadians) {
  const auto packet = test::ouster_imu_packet(123, {0.1, -0.2, 1.0}, {90.0, 0.0, -180.0});
  const ImuSample sample = ouster_imu(packet.data());
  EXPECT_EQ(sample.stamp, 123);
  EXPECT_TRUE(near(sample.linear_acceleration, Eigen::Vector3d(0.980665, -1.96133, 9.80665), 1e-6));
  EXPECT_TRUE(near(sample.angular_velocity, Eigen::Vector3d(kPi / 2.0, 0.0, -kPi), 1e-6));
}

TEST(Ouster, ATimeOfTheImuThatNoClockHasIsRefused) {
  constexpr std::uint64_t kLast = std::uint64_t{1} << 62U;
  const auto packet_at = [](std::uint64_t time) {
    return test::ouster_imu_packet(time, {0.0, 0.0, 1.0}, {0.0, 0.0, 0.0});
  };
  EXPECT_EQ(ouster_imu(packet_at(kLast).data()).stamp, static_cast<Stamp>(kLast));
  EXPECT_THROW(ouster_imu(packet_at(kLast + 1).data()), InputError);
  EXPECT_THROW(ouster_imu(packet_at(0xFFFF'FFFF'FFFF'0000).data()), InputError);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
