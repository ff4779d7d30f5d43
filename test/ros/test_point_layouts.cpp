// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "clouds/point_fields.hpp"
#include "decoded_cloud.hpp"

namespace lidar_mapping::ros_border {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using test::absolute_cloud;
using test::cloud_with;
using test::expect_points;
using test::fraction;
using test::kCount;
using test::kPeriod;
using test::plain_cloud;
using test::put;
using test::turn_time;
using test::xyz_cloud;

TEST(PointLayouts, ReadsVelodyne) {
  auto message = xyz_cloud({{"intensity", PointField::FLOAT32, 12},
                            {"ring", PointField::UINT16, 16},
                            {"time", PointField::FLOAT32, 18}},
                           22, kCount);
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

TEST(PointLayouts, ReadsOusterOrganisedWithPadding) {
  auto message = xyz_cloud({{"intensity", PointField::FLOAT32, 16},
                            {"t", PointField::UINT32, 20},
                            {"reflectivity", PointField::UINT16, 24},
                            {"ring", PointField::UINT8, 26},
                            {"ambient", PointField::UINT16, 28},
                            {"range", PointField::UINT32, 32}},
                           48, kCount);
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

TEST(PointLayouts, ReadsLivox) {
  auto message = xyz_cloud({{"reflectivity", PointField::UINT8, 12},
                            {"tag", PointField::UINT8, 13},
                            {"line", PointField::UINT8, 14},
                            {"offset_time", PointField::UINT32, 15}},
                           19, kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    put(message, i, 12, static_cast<std::uint8_t>(200));
    put(message, i, 15, static_cast<std::uint32_t>(std::lround(fraction(i) * 1e8)));
  }
  const DecodedCloud decoded = decode(message, {});
  expect_points(decoded, turn_time, 1e-8);
  EXPECT_EQ(decoded.scan.cloud.points[0].intensity, 200.0F);
  EXPECT_EQ(decoded.format.intensity_field, "reflectivity");
}

TEST(PointLayouts, ReadsPointsThatDoNotBeginWithTheirCoordinates) {
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
  expect_points(decoded, turn_time, 1e-6);
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(decoded.scan.cloud.points[i].intensity, 0.5F * static_cast<float>(i));
  }
}

TEST(PointLayouts, LeavesPointsOfTheUsualLayoutWhereTheyAre) {
  for (const std::uint32_t step : {20U, 32U}) {
    auto message = std::make_shared<PointCloud2>(plain_cloud(step));
    const DecodedCloud read = decode(*message, {});
    EXPECT_FALSE(read.scan.packed);
    DecodedCloud lazy = decode_lazily(*message, message, {});
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

TEST(PointLayouts, ReadsOtherLayoutsAtOnce) {
  PointCloud2 message = absolute_cloud(1.0, ros::Time(1673400677, 0), 0.0);
  message.fields.front().datatype = PointField::FLOAT64;
  EXPECT_FALSE(decode_lazily(message, nullptr, {}).scan.packed);
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

TEST(PointLayouts, ReadsIntensitiesOfAnyType) {
  expect_intensities<std::uint8_t>(PointField::UINT8);
  expect_intensities<std::uint16_t>(PointField::UINT16);
  expect_intensities<std::int16_t>(PointField::INT16);
  expect_intensities<std::uint32_t>(PointField::UINT32);
  expect_intensities<std::int32_t>(PointField::INT32);
  expect_intensities<float>(PointField::FLOAT32);
  expect_intensities<double>(PointField::FLOAT64);
}

TEST(PointLayouts, ReadsIntensitiesUnderEveryName) {
  for (const char* name : kIntensityNames) {
    auto message = xyz_cloud({{name, PointField::UINT8, 12}}, 16, kCount);
    put(message, 5, 12, std::uint8_t{200});
    EXPECT_EQ(decode(message, {}).scan.cloud.points[5].intensity, 200.0F) << name;
  }
}

TEST(PointLayouts, ReadsIntensitiesUnderNamesInAnyCase) {
  for (const char* name : {"Intensity", "REFLECTIVITY", "I"}) {
    auto message = xyz_cloud({{name, PointField::UINT8, 12}}, 16, kCount);
    put(message, 5, 12, std::uint8_t{200});
    EXPECT_EQ(decode(message, {}).scan.cloud.points[5].intensity, 200.0F) << name;
  }
}

TEST(PointLayouts, TakesCloudsOfCoordinatesAlone) {
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

TEST(PointLayouts, TakesEmptyClouds) {
  PointCloud2 message;
  EXPECT_TRUE(decode(message, {}).scan.cloud.empty());
}

TEST(PointLayouts, RefusesWhatCannotBeRead) {
  auto good = xyz_cloud({}, 12, kCount);
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

}  // namespace
}  // namespace lidar_mapping::ros_border
