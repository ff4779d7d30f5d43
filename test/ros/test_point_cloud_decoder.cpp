// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

#include "cloud_builder.hpp"
#include "test_data.hpp"

namespace lidar_mapping::ros_border {
namespace {

using preprocessing::PreprocessingConfig;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using test::cloud_with;
using test::put;
using test::put_positions;

constexpr std::uint32_t kCount = 1000;
constexpr double kPeriod = 0.1;

double fraction(std::size_t i) { return static_cast<double>(i) / (kCount - 1); }

/// The points of put_positions() and, for each, `time(i)`.
template <typename Time>
void expect_points(const DecodedCloud& decoded, const Time& time, double tolerance) {
  const PointCloud& cloud = decoded.scan.cloud;
  ASSERT_EQ(cloud.size(), kCount);
  ASSERT_EQ(cloud.times.size(), kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(cloud.points[i].position(),
              (Eigen::Vector3f(1, 2, 3) * static_cast<float>(i)).eval());
    EXPECT_NEAR(cloud.times[i], time(i), tolerance);
  }
}

TEST(PointCloudDecoder, ReadsVelodyne) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"intensity", PointField::FLOAT32, 12},
                             {"ring", PointField::UINT16, 16},
                             {"time", PointField::FLOAT32, 18}},
                            22, kCount);
  put_positions(message);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, 12, static_cast<float>(i % 256));
    put(message, i, 18, static_cast<float>(kPeriod * (fraction(i) - 1.0)));
  }
  const DecodedCloud decoded = decode(message, {});
  expect_points(
      decoded, [](std::size_t i) { return kPeriod * (fraction(i) - 1.0); }, 1e-7);
  EXPECT_EQ(decoded.scan.cloud.points[300].intensity, 44.0F);
  EXPECT_EQ(decoded.format.time_unit, "s");
  EXPECT_FALSE(decoded.scan.times_are_absolute);
}

TEST(PointCloudDecoder, ReadsOusterOrganisedWithPadding) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"intensity", PointField::FLOAT32, 16},
                             {"t", PointField::UINT32, 20},
                             {"reflectivity", PointField::UINT16, 24},
                             {"ring", PointField::UINT8, 26},
                             {"ambient", PointField::UINT16, 28},
                             {"range", PointField::UINT32, 32}},
                            48, kCount);
  put_positions(message);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, 16, 7.0F);
    put(message, i, 20, static_cast<std::uint32_t>(std::lround(fraction(i) * 99.9e6)));
    put(message, i, 24, static_cast<std::uint16_t>(9));
  }
  // The same points in 4 rows, each with padding at its end.
  PointCloud2 organised = message;
  organised.height = 4;
  organised.width = kCount / 4;
  organised.row_step = organised.width * 48 + 32;
  organised.data.assign(organised.row_step * 4, 0xAB);
  for (std::size_t row = 0; row < 4; ++row) {
    std::copy_n(message.data.begin() + static_cast<std::ptrdiff_t>(row * 48 * kCount / 4),
                48 * kCount / 4,
                organised.data.begin() + static_cast<std::ptrdiff_t>(row * organised.row_step));
  }
  for (const PointCloud2& layout : {message, organised}) {
    const DecodedCloud decoded = decode(layout, {});
    expect_points(
        decoded, [](std::size_t i) { return fraction(i) * 0.0999; }, 1e-8);
    EXPECT_EQ(decoded.format.time_unit, "ns");
    EXPECT_EQ(decoded.scan.cloud.points[5].intensity, 7.0F);
  }
}

/// x y z intensity ring timestamp as Hesai and RoboSense have them.
PointCloud2 absolute_cloud(double unit, const ros::Time& stamp, double first) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"intensity", PointField::FLOAT32, 16},
                             {"timestamp", PointField::FLOAT64, 24},
                             {"ring", PointField::UINT16, 32}},
                            48, kCount, stamp);
  put_positions(message);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double since_second = 1e-9 * stamp.nsec + first + kPeriod * fraction(i);
    put(message, i, 24, (stamp.sec + since_second) / unit);
  }
  return message;
}

TEST(PointCloudDecoder, ReadsAbsoluteTimesInAnyUnit) {  // A float cannot hold them
  const ros::Time stamp(1673400677, 700635123);
  for (const double unit : {1.0, 1e-3, 1e-6, 1e-9}) {
    for (const double first : {0.0, -0.1, -0.05}) {
      const DecodedCloud decoded = decode(absolute_cloud(unit, stamp, first), {});
      expect_points(
          decoded, [&](std::size_t i) { return first + kPeriod * fraction(i); }, 1e-6);
      EXPECT_TRUE(decoded.scan.times_are_absolute);
      EXPECT_EQ(decoded.scan.stamp, 1673400677700635123);
    }
  }
}

/// x y z and two fields with the parts of a time.
PointCloud2 cloud_of_two_times(const std::string& first, const std::string& second,
                               std::uint8_t type, const ros::Time& stamp) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {second, PointField::UINT32, 12},
                             {first, type, 16}},
                            24, kCount, stamp);
  put_positions(message);
  return message;
}

/// Of a scan that begins 20 ms before the stamp, in a second that ends during the scan.
TEST(PointCloudDecoder, AddsSecondsAndWhatIsBeyondThem) {
  const ros::Time stamp(1673400677, 990000000);
  const struct {
    const char* first;
    const char* second;
    std::uint32_t unit_ns;
  } kNames[] = {{"time_sec", "time_nsec", 1},       {"sec", "nanosec", 1},
                {"timestamp_s", "timestamp_ns", 1}, {"timeSecond", "timeNanosecond", 1},
                {"t_sec", "t_usec", 1000},          {"seconds", "microseconds", 1000}};
  for (const auto& names : kNames) {
    for (const std::uint8_t type : {PointField::UINT32, PointField::FLOAT64}) {
      auto message = cloud_of_two_times(names.first, names.second, type, stamp);
      for (std::size_t i = 0; i < kCount; ++i) {
        const auto time = static_cast<std::uint64_t>(
            std::llround(1e9 * (0.97 + kPeriod * fraction(i))) + 1673400677'000000000LL);
        const auto sec = static_cast<std::uint32_t>(time / 1'000'000'000);
        type == PointField::UINT32 ? put(message, i, 16, sec)
                                   : put(message, i, 16, double{1.0} * sec);
        put(message, i, 12, static_cast<std::uint32_t>(time % 1'000'000'000 / names.unit_ns));
      }
      const DecodedCloud decoded = decode(message, {});
      expect_points(
          decoded, [](std::size_t i) { return kPeriod * fraction(i) - 0.02; }, 1.1e-6);
      EXPECT_TRUE(decoded.scan.times_are_absolute) << names.first;
      EXPECT_EQ(decoded.format.time_field,
                std::string(names.first) + " + " + std::string(names.second));
      EXPECT_EQ(decoded.format.time_unit, "s");
    }
  }
}

TEST(PointCloudDecoder, AddsTheHalvesOfALongCount) {
  const ros::Time stamp(1673400677, 700635123);
  for (const auto& [high, low] :
       {std::pair{"timestamp_h", "timestamp_l"}, std::pair{"time_high", "time_low"}}) {
    auto message = cloud_of_two_times(high, low, PointField::UINT32, stamp);
    for (std::size_t i = 0; i < kCount; ++i) {
      const auto time = static_cast<std::uint64_t>(1673400677'700635123LL +
                                                   std::llround(1e9 * kPeriod * fraction(i)));
      put(message, i, 16, static_cast<std::uint32_t>(time >> 32U));
      put(message, i, 12, static_cast<std::uint32_t>(time & 0xFFFFFFFFU));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(
        decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-6);
    EXPECT_EQ(decoded.format.time_unit, "ns");
    EXPECT_TRUE(decoded.scan.times_are_absolute);
  }
}

/// As pcl::toROSMsg() writes fields of type uint64_t and int64_t.
TEST(PointCloudDecoder, ReadsCountsOfEightBytes) {
  constexpr std::uint8_t kInt64 = 9, kUint64 = 10;
  for (const std::uint8_t type : {kInt64, kUint64}) {
    auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                               {"y", PointField::FLOAT32, 4},
                               {"z", PointField::FLOAT32, 8},
                               {"TimeStamp", type, 16}},
                              24, kCount, ros::Time(1673400677, 0));
    put_positions(message);
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 16, std::int64_t{1673400677'000000000} + std::llround(1e8 * fraction(i)));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(
        decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-6);
    EXPECT_EQ(decoded.format.time_unit, "ns");
    EXPECT_EQ(decoded.format.time_field, "TimeStamp");
  }
}

TEST(PointCloudDecoder, ReadsTimesUnderOtherNames) {
  for (const char* name : {"ts", "TIME", "time_offset_ns", "t_ns", "timestamp_ns", "stamp"}) {
    auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                               {"y", PointField::FLOAT32, 4},
                               {"z", PointField::FLOAT32, 8},
                               {name, PointField::UINT32, 12}},
                              16, kCount);
    put_positions(message);
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 12, static_cast<std::uint32_t>(std::lround(1e8 * fraction(i))));
    }
    expect_points(
        decode(message, {}), [](std::size_t i) { return kPeriod * fraction(i); }, 1e-6);
  }
}

TEST(PointCloudDecoder, IgnoresHalvesThatNobodyFilledAndNumbersThatAreNone) {
  auto message = cloud_of_two_times("time_sec", "time_nsec", PointField::FLOAT64, ros::Time(5, 0));
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
  put(message, 0, 16, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
  message.fields.back().offset = 20;  // its end is outside of the point
  EXPECT_THROW(decode(message, {}), InputError);
}

/// x y z intensity time, with points of `step` bytes.
PointCloud2 plain_cloud(std::uint32_t step) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"intensity", PointField::FLOAT32, step - 8},
                             {"time", PointField::FLOAT32, step - 4}},
                            step, kCount);
  put_positions(message);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, step - 8, static_cast<float>(i));
    put(message, i, step - 4, static_cast<float>(kPeriod * fraction(i)));
  }
  return message;
}

TEST(PointCloudDecoder, LeavesPointsOfTheUsualLayoutWhereTheyAre) {
  for (const std::uint32_t step : {20U, 32U}) {
    auto message = boost::make_shared<PointCloud2>(plain_cloud(step));
    const DecodedCloud read = decode(*message, {});
    EXPECT_FALSE(read.scan.packed);
    DecodedCloud lazy = decode_lazily(message, {});
    message.reset();  // the scan keeps what it needs
    ASSERT_TRUE(lazy.scan.packed);
    EXPECT_EQ(lazy.scan.cloud.times, read.scan.cloud.times);
    ASSERT_EQ(lazy.scan.cloud.size(), kCount);
    lazy.scan.unpack();
    for (std::size_t i = 0; i < kCount; ++i) {
      EXPECT_EQ(lazy.scan.cloud.points[i].position(), read.scan.cloud.points[i].position());
      EXPECT_EQ(lazy.scan.cloud.points[i].intensity, static_cast<float>(i));
    }
  }
}

TEST(PointCloudDecoder, ReadsPointsThatDoNotBeginWithTheirCoordinates) {
  auto message = cloud_with({{"timestamp", PointField::FLOAT64, 0},
                             {"x", PointField::FLOAT32, 8},
                             {"y", PointField::FLOAT32, 12},
                             {"z", PointField::FLOAT32, 16},
                             {"ring", PointField::UINT32, 20},
                             {"intensity", PointField::FLOAT32, 24}},
                            28, kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto value = static_cast<float>(i);
    put(message, i, 0, kPeriod * fraction(i));
    put(message, i, 8, value);
    put(message, i, 12, 2.0F * value);
    put(message, i, 16, 3.0F * value);
    put(message, i, 24, 0.5F * value);
  }
  const DecodedCloud decoded = decode(message, {});
  expect_points(
      decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-6);
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(decoded.scan.cloud.points[i].intensity, 0.5F * static_cast<float>(i));
  }
}

TEST(PointCloudDecoder, ReadsOtherLayoutsAtOnce) {
  const auto message =
      boost::make_shared<PointCloud2>(absolute_cloud(1.0, ros::Time(1673400677, 0), 0.0));
  message->fields.front().datatype = PointField::FLOAT64;
  EXPECT_FALSE(decode_lazily(message, {}).scan.packed);
}

TEST(PointCloudDecoder, CountsTimesOfAForeignClockFromTheFirstPoint) {
  PointCloud2 message = absolute_cloud(1.0, ros::Time(1673400677, 0), 0.0);
  message.header.stamp = ros::Time(1700000000, 0);
  const DecodedCloud decoded = decode(message, {});
  expect_points(
      decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-6);
  EXPECT_TRUE(decoded.format.foreign_clock);
  EXPECT_FALSE(decoded.scan.times_are_absolute);
}

TEST(PointCloudDecoder, ReadsLivox) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"reflectivity", PointField::UINT8, 12},
                             {"tag", PointField::UINT8, 13},
                             {"line", PointField::UINT8, 14},
                             {"offset_time", PointField::UINT32, 15}},
                            19, kCount);
  put_positions(message);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, 12, static_cast<std::uint8_t>(200));
    put(message, i, 15, static_cast<std::uint32_t>(std::lround(fraction(i) * 1e8)));
  }
  const DecodedCloud decoded = decode(message, {});
  expect_points(
      decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-8);
  EXPECT_EQ(decoded.scan.cloud.points[0].intensity, 200.0F);
  EXPECT_EQ(decoded.format.intensity_field, "reflectivity");
}

/// Coordinates as doubles and an intensity of any type, organised, with returns that are not there.
template <typename Intensity>
void expect_intensities(std::uint8_t datatype) {
  auto message = cloud_with({{"x", PointField::FLOAT64, 0},
                             {"y", PointField::FLOAT64, 8},
                             {"z", PointField::FLOAT64, 16},
                             {"intensity", datatype, 24},
                             {"t", PointField::UINT32, 32}},
                            36, 64);
  message.height = 4;
  message.width = 16;
  message.row_step = 16 * 36;
  message.is_dense = false;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const bool is_there = i % 4 != 3;
    put(message, i, 0, is_there ? 0.5 * i : std::numeric_limits<double>::quiet_NaN());
    put(message, i, 24, static_cast<Intensity>(i + 100));
    put(message, i, 32, i * 1500000U);
  }
  const PointCloud cloud = decode(message, {}).scan.cloud;
  ASSERT_EQ(cloud.size(), 64U);
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_EQ(std::isnan(cloud.points[i].x), i % 4 == 3);
    EXPECT_EQ(cloud.points[i].intensity, static_cast<float>(i + 100)) << int{datatype};
    EXPECT_NEAR(cloud.times[i], 0.0015 * static_cast<double>(i), 1e-8);
  }
}

TEST(PointCloudDecoder, ReadsIntensitiesOfAnyType) {
  expect_intensities<std::uint8_t>(PointField::UINT8);
  expect_intensities<std::uint16_t>(PointField::UINT16);
  expect_intensities<std::int16_t>(PointField::INT16);
  expect_intensities<std::uint32_t>(PointField::UINT32);
  expect_intensities<std::int32_t>(PointField::INT32);
  expect_intensities<float>(PointField::FLOAT32);
  expect_intensities<double>(PointField::FLOAT64);
}

/// Sensors that turn at 5 and 20 Hz, with the period of 10 Hz as it is configured.
TEST(PointCloudDecoder, FindsTheUnitAtOtherRates) {
  for (const double period : {0.05, 0.2}) {
    for (const auto& [unit, name] :
         {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}, std::pair{1e-6, "us"}}) {
      auto message = plain_cloud(20);
      for (std::size_t i = 0; i < kCount; ++i) {
        put(message, i, 16, static_cast<float>(period * fraction(i) / unit));
      }
      const DecodedCloud decoded = decode(message, {});
      EXPECT_EQ(decoded.format.time_unit, name) << period;
      EXPECT_NEAR(decoded.scan.cloud.times.back(), period, 1e-6);
    }
  }
}

TEST(PointCloudDecoder, FindsTheUnitOfFloatsByThePeriod) {
  for (const auto& [unit, name] :
       {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}, std::pair{1e-6, "us"}, std::pair{1e-9, "ns"}}) {
    auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                               {"y", PointField::FLOAT32, 4},
                               {"z", PointField::FLOAT32, 8},
                               {"time_stamp", PointField::FLOAT32, 12}},
                              16, kCount);
    put_positions(message);
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 12, static_cast<float>(kPeriod * fraction(i) / unit));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(
        decoded, [](std::size_t i) { return kPeriod * fraction(i); }, 1e-7);
    EXPECT_EQ(decoded.format.time_unit, name);
  }
}

TEST(PointCloudDecoder, ObeysTheConfiguredUnitAndSwitch) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"t", PointField::UINT32, 12}},
                            16, kCount);
  for (std::size_t i = 0; i < kCount; ++i) put(message, i, 12, static_cast<std::uint32_t>(i));
  PreprocessingConfig config;
  config.point_time_unit = preprocessing::PointTimeUnit::kMicroseconds;
  EXPECT_NEAR(decode(message, config).scan.cloud.times.back(), 999e-6, 1e-9);
  config.point_times = preprocessing::PointTimes::kNone;
  EXPECT_FALSE(decode(message, config).scan.cloud.has_times());
}

TEST(PointCloudDecoder, TakesCloudsOfCoordinatesAlone) {
  auto message = cloud_with({{"z", PointField::FLOAT64, 0},
                             {"x", PointField::FLOAT64, 8},
                             {"y", PointField::FLOAT64, 16}},
                            24, 2);
  put(message, 1, 0, 3.0);
  put(message, 1, 8, 1.0);
  put(message, 1, 16, std::numeric_limits<double>::quiet_NaN());
  const DecodedCloud decoded = decode(message, {});
  ASSERT_EQ(decoded.scan.cloud.size(), 2U);
  EXPECT_EQ(decoded.scan.cloud.points[1].x, 1.0F);
  EXPECT_EQ(decoded.scan.cloud.points[1].z, 3.0F);
  EXPECT_TRUE(std::isnan(decoded.scan.cloud.points[1].y));
  EXPECT_FALSE(decoded.scan.cloud.has_times());
}

TEST(PointCloudDecoder, IgnoresTimesThatNobodyFilled) {
  auto message = cloud_with({{"x", PointField::FLOAT32, 0},
                             {"y", PointField::FLOAT32, 4},
                             {"z", PointField::FLOAT32, 8},
                             {"t", PointField::UINT32, 12}},
                            16, kCount);
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
}

TEST(PointCloudDecoder, TakesEmptyClouds) {
  PointCloud2 message;
  EXPECT_TRUE(decode(message, {}).scan.cloud.empty());
}

TEST(PointCloudDecoder, RefusesWhatCannotBeRead) {
  auto good = cloud_with(
      {{"x", PointField::FLOAT32, 0}, {"y", PointField::FLOAT32, 4}, {"z", PointField::FLOAT32, 8}},
      12, kCount);
  EXPECT_NO_THROW(decode(good, {}));
  const auto refuses = [&](auto&& spoil) {
    PointCloud2 message = good;
    spoil(message);
    EXPECT_THROW(decode(message, {}), InputError);
  };
  refuses([](PointCloud2& m) { m.is_bigendian = true; });
  refuses([](PointCloud2& m) { m.data.resize(m.data.size() - 1); });
  refuses([](PointCloud2& m) { m.fields.pop_back(); });
  refuses([](PointCloud2& m) { m.fields[0].datatype = PointField::UINT16; });
  refuses([](PointCloud2& m) { m.fields[0].datatype = 77; });
  refuses([](PointCloud2& m) { m.fields[2].offset = 9; });
  refuses([](PointCloud2& m) { m.fields[2].offset = 0xFFFFFFFF; });
  refuses([](PointCloud2& m) { m.point_step = 0; });
  refuses([](PointCloud2& m) { m.width = 0xFFFFFFFF; });
  refuses([](PointCloud2& m) { m.height = 0xFFFFFFFF; });
  refuses([](PointCloud2& m) {
    m.height = 2;
    m.row_step = 1;
  });
}

/// Times of a recorded scan span about its period and refer to its stamp.
void expect_recorded(const std::filesystem::path& file, const ros::Time& stamp,
                     const std::string& unit, bool absolute) {
  const DecodedCloud decoded = decode(test::read_pcd(file, stamp), {});
  const auto& times = decoded.scan.cloud.times;
  ASSERT_EQ(times.size(), decoded.scan.cloud.size());
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  EXPECT_NEAR(*last - *first, 0.1, 0.005);
  EXPECT_LT(std::abs(*first), 0.11);
  EXPECT_EQ(decoded.format.time_unit, unit);
  EXPECT_EQ(decoded.scan.times_are_absolute, absolute);
  EXPECT_FALSE(decoded.format.foreign_clock);
}

TEST(PointCloudDecoder, ReadsRecordedVelodyne) {
  REQUIRE_RECORDED(folder, "velodyne_vlp16");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "s", false);
}

TEST(PointCloudDecoder, ReadsRecordedOuster) {
  REQUIRE_RECORDED(folder, "ouster_os1_128");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "ns", false);
}

TEST(PointCloudDecoder, ReadsRecordedHesai) {
  REQUIRE_RECORDED(folder, "hesai_xt32");
  expect_recorded(folder / "000000.pcd", ros::Time(1673400677, 700635000), "s", true);
}

TEST(PointCloudDecoder, ReadsRecordedRoboSense) {
  REQUIRE_RECORDED(folder, "robosense_32");
  expect_recorded(folder / "000000.pcd", ros::Time(1600000000, 5), "ns", false);
}

TEST(PointCloudDecoder, ReadsRecordedRingsWithoutTimes) {
  REQUIRE_RECORDED(folder, "ring32");
  const DecodedCloud decoded = decode(test::read_pcd(folder / "000000.pcd", ros::Time(5, 0)), {});
  EXPECT_GT(decoded.scan.cloud.size(), 10000U);
  EXPECT_FALSE(decoded.scan.cloud.has_times());
}

}  // namespace
}  // namespace lidar_mapping::ros_border
