// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "clouds/point_fields.hpp"
#include "decoded_cloud.hpp"

namespace lidar_mapping::ros_border {
namespace {

using preprocessing::PreprocessingConfig;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using test::absolute_cloud;
using test::expect_points;
using test::fraction;
using test::kCount;
using test::kPeriod;
using test::plain_cloud;
using test::put;
using test::turn_time;
using test::xyz_cloud;

TEST(PointTimes, ReadsAbsoluteTimesInAnyUnit) {  // A float cannot hold them
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
  auto message =
      xyz_cloud({{second, PointField::UINT32, 12}, {first, type, 16}}, 24, kCount, stamp);
  return message;
}

/// Of a scan that begins 20 ms before the stamp, in a second that ends during the scan.
TEST(PointTimes, AddsSecondsAndWhatIsBeyondThem) {
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

TEST(PointTimes, AddsTheHalvesOfALongCount) {
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
    expect_points(decoded, turn_time, 1e-6);
    EXPECT_EQ(decoded.format.time_unit, "ns");
    EXPECT_TRUE(decoded.scan.times_are_absolute);
  }
}

TEST(PointTimes, IgnoresHalvesThatNobodyFilledAndNumbersThatAreNone) {
  auto message = cloud_of_two_times("time_sec", "time_nsec", PointField::FLOAT64, ros::Time(5, 0));
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
  put(message, 0, 16, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
  message.fields.back().offset = 20;  // its end is outside of the point
  EXPECT_THROW(decode(message, {}), InputError);
}

/// As pcl::toROSMsg() writes fields of type uint64_t and int64_t.
TEST(PointTimes, ReadsCountsOfEightBytes) {
  constexpr std::uint8_t kInt64 = 9, kUint64 = 10;
  for (const std::uint8_t type : {kInt64, kUint64}) {
    auto message = xyz_cloud({{"TimeStamp", type, 16}}, 24, kCount, ros::Time(1673400677, 0));
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 16, std::int64_t{1673400677'000000000} + std::llround(1e8 * fraction(i)));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(decoded, turn_time, 1e-6);
    EXPECT_EQ(decoded.format.time_unit, "ns");
    EXPECT_EQ(decoded.format.time_field, "TimeStamp");
  }
}

TEST(PointTimes, ReadsTimesUnderEveryName) {
  std::vector<std::string> names(kTimeNames.begin(), kTimeNames.end());
  names.emplace_back("TIME");  // they may be of any case
  for (const std::string& name : names) {
    auto message = xyz_cloud({{name, PointField::UINT32, 12}}, 16, kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 12, static_cast<std::uint32_t>(std::lround(1e8 * fraction(i))));
    }
    expect_points(decode(message, {}), turn_time, 1e-6);
  }
}

/// A count of 32 bits, and nanoseconds of the second, 40 ms before they begin anew.
TEST(PointTimes, UnrollsAClockThatBeginsAnewDuringTheScan) {
  for (const std::uint64_t round : {std::uint64_t{1} << 32, std::uint64_t{1'000'000'000}}) {
    auto message = xyz_cloud({{"t", PointField::UINT32, 12}}, 16, kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      const auto since_first = static_cast<std::uint64_t>(std::lround(1e8 * fraction(i)));
      const std::uint64_t count = round - 40'000'000 + since_first;
      put(message, i, 12, static_cast<std::uint32_t>(count % round));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(decoded, turn_time, 1e-6);
    EXPECT_EQ(decoded.format.time_unit, "ns") << round;
    EXPECT_TRUE(decoded.format.foreign_clock) << round;
  }
}

TEST(PointTimes, CountsTimesOfAForeignClockFromTheFirstPoint) {
  PointCloud2 message = absolute_cloud(1.0, ros::Time(1673400677, 0), 0.0);
  message.header.stamp = ros::Time(1700000000, 0);
  const DecodedCloud decoded = decode(message, {});
  expect_points(decoded, turn_time, 1e-6);
  EXPECT_TRUE(decoded.format.foreign_clock);
  EXPECT_FALSE(decoded.scan.times_are_absolute);
}

/// Sensors that turn at 5 and 20 Hz, with the period of 10 Hz as it is configured.
TEST(PointTimes, FindsTheUnitAtOtherRates) {
  for (const double period : {0.05, 0.2}) {
    for (const auto& [unit, name] :
         {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}, std::pair{1e-6, "us"}}) {
      auto message = plain_cloud(20);
      for (std::size_t i = 0; i < kCount; ++i) {
        put(message, i, 16, static_cast<float>(period * fraction(i) / unit));
      }
      const DecodedCloud decoded = decode(message, {});
      EXPECT_EQ(decoded.format.time_unit, name) << period;
      ASSERT_TRUE(decoded.scan.cloud.has_times()) << name;
      EXPECT_NEAR(decoded.scan.cloud.times.back(), period, 1e-6);
    }
  }
}

TEST(PointTimes, FindsTheUnitOfFloatsByThePeriod) {
  for (const auto& [unit, name] :
       {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}, std::pair{1e-6, "us"}, std::pair{1e-9, "ns"}}) {
    auto message = xyz_cloud({{"time_stamp", PointField::FLOAT32, 12}}, 16, kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      put(message, i, 12, static_cast<float>(kPeriod * fraction(i) / unit));
    }
    const DecodedCloud decoded = decode(message, {});
    expect_points(decoded, turn_time, 1e-7);
    EXPECT_EQ(decoded.format.time_unit, name);
  }
}

/// A part of a turn and five turns, whose length says nothing about the unit.
TEST(PointTimes, TakesTheUnitFromTheNameWhereNoneFitsThePeriod) {
  for (const auto& [name, unit] : {std::pair{"time_us", 1e-6}, std::pair{"Time_NS", 1e-9},
                                   std::pair{"time_offset_ns", 1e-9}, std::pair{"usec", 1e-6}}) {
    for (const double span : {0.005, 0.5}) {
      auto message = xyz_cloud({{name, PointField::UINT32, 12}}, 16, kCount);
      for (std::size_t i = 0; i < kCount; ++i) {
        put(message, i, 12, static_cast<std::uint32_t>(std::llround(span * fraction(i) / unit)));
      }
      const DecodedCloud decoded = decode(message, {});
      ASSERT_TRUE(decoded.scan.cloud.has_times()) << name;
      EXPECT_NEAR(decoded.scan.cloud.times.back(), span, 1e-6) << name;
    }
  }
}

TEST(PointTimes, ObeysTheConfiguredUnitAndSwitch) {
  auto message = xyz_cloud({{"t", PointField::UINT32, 12}}, 16, kCount);
  for (std::size_t i = 0; i < kCount; ++i) put(message, i, 12, static_cast<std::uint32_t>(i));
  PreprocessingConfig config;
  config.point_time_unit = preprocessing::PointTimeUnit::kMicroseconds;
  const DecodedCloud decoded = decode(message, config);
  ASSERT_TRUE(decoded.scan.cloud.has_times());
  EXPECT_NEAR(decoded.scan.cloud.times.back(), 999e-6, 1e-9);
  config.point_times = preprocessing::PointTimes::kNone;
  EXPECT_FALSE(decode(message, config).scan.cloud.has_times());
}

TEST(PointTimes, IgnoresTimesThatNobodyFilled) {
  auto message = xyz_cloud({{"t", PointField::UINT32, 12}}, 16, kCount);
  EXPECT_FALSE(decode(message, {}).scan.cloud.has_times());
}

}  // namespace
}  // namespace lidar_mapping::ros_border
