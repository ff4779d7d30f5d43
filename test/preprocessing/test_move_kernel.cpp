// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/scan_pass.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "near.hpp"
#include "points/move_kernel.hpp"
#include "points/times_kernel.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// 30 m/s and 1 rad/s, as fast as a vehicle drives and turns at once, over [-0.05, 0.06] s.
ScanMotion fast_motion() {
  const auto turning = [](double) { return Eigen::Vector3d(0.1, -0.1, 1.0); };
  const auto driving = [](double, const Eigen::Vector3d&) {
    return Eigen::Vector3d(30.0, 0.5, 0.1);
  };
  return *integrated(-0.05, 0.06, turning, driving);
}

constexpr std::size_t kBefore = 3;  // bytes: nothing is aligned

enum class Order { kByTime, kByBeam, kShuffled };

/// Points out to 100 m; a beam of 500 points after the other, or as they were measured.
PointCloud cloud_in(Order order, std::size_t count) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> axis(-57.0F, 57.0F);
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = order == Order::kByTime
                             ? static_cast<double>(i) / static_cast<double>(count)
                             : static_cast<double>(i % 500) / 500.0;
    cloud.points.push_back({axis(engine), axis(engine), axis(engine), static_cast<float>(i)});
    cloud.times.push_back(static_cast<float>(-0.05 + 0.11 * share));
  }
  if (order == Order::kShuffled) std::shuffle(cloud.times.begin(), cloud.times.end(), engine);
  return cloud;
}

TEST(MoveKernel, IsAccurateToATenthOfAMillimetre) {
  const ScanMotion motion = fast_motion();
  const Pose T_base_sensor{exp_so3({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0}};
  const Pose R_base_sensor{T_base_sensor.rotation, Eigen::Vector3d::Zero()};
  for (const Order order : {Order::kByTime, Order::kByBeam, Order::kShuffled}) {
    const PointCloud raw = cloud_in(order, 5003);
    PointCloud moved = raw;
    keep_and_deskew(packed_in(moved), moved, T_base_sensor, PassLimits({}), &motion);
    ASSERT_GT(moved.size(), 4900U);
    double worst = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const auto source = static_cast<std::size_t>(moved.points[i].intensity);
      EXPECT_EQ(moved.times[i], raw.times[source]);
      const Pose T_sensor_then =
          R_base_sensor.inverse() * motion.at(raw.times[source]) * R_base_sensor;
      const Eigen::Vector3d exact = T_sensor_then * raw.points[source].position().cast<double>();
      worst = std::max(worst, (moved.points[i].position().cast<double>() - exact).norm());
    }
    EXPECT_LT(worst, 1e-4) << static_cast<int>(order);
  }
}

TEST(MoveKernel, KeepsTheMotionConstantBeyondItsEnds) {
  const ScanMotion motion = fast_motion();
  PointCloud cloud = cloud_in(Order::kByTime, 16);
  std::fill(cloud.times.begin(), cloud.times.begin() + 8, -1.0F);
  std::fill(cloud.times.begin() + 8, cloud.times.end(), 1.0F);
  const PointCloud raw = cloud;
  keep_and_deskew(packed_in(cloud), cloud, Pose::Identity(), PassLimits({}), &motion);
  ASSERT_EQ(cloud.size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) {
    const Pose& T_stamp_end = i < 8 ? motion.T_stamp_knot.front() : motion.T_stamp_knot.back();
    const Eigen::Vector3d exact = T_stamp_end * raw.points[i].position().cast<double>();
    EXPECT_TRUE(test::near(cloud.points[i].position().cast<double>(), exact, 1e-4)) << i;
  }
}

// One of them would make the mean of its whole voxel one.
TEST(MoveKernel, ClearsIntensitiesThatAreNotFinite) {
  for (const std::size_t count : {1U, 16U, 41U}) {
    PointCloud cloud = cloud_in(Order::kByTime, count);
    for (std::size_t i = 0; i < count; i += 3) {
      cloud.points[i].intensity = i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                             : -std::numeric_limits<float>::infinity();
    }
    keep_and_deskew(packed_in(cloud), cloud, Pose::Identity(), PassLimits({}), nullptr);
    ASSERT_EQ(cloud.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(cloud.points[i].intensity, i % 3 == 0 ? 0.0F : static_cast<float>(i)) << i;
    }
  }
}

/// How a driver may lay out its points.
struct Layout {
  std::size_t step, intensity;
};
constexpr Layout kLayouts[] = {{16, 12}, {20, 12}, {22, 12}, {48, 16}};

/// The points of the cloud in that layout, after some bytes of something else.
std::vector<unsigned char> packed(const PointCloud& cloud, const Layout& layout) {
  std::vector<unsigned char> bytes(kBefore + layout.step * cloud.size(), 0xAB);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    unsigned char* const point = bytes.data() + kBefore + i * layout.step;
    std::memcpy(point, &cloud.points[i].x, 3 * sizeof(float));
    std::memcpy(point + layout.intensity, &cloud.points[i].intensity, sizeof(float));
  }
  return bytes;
}

/// What a kernel makes of a cloud, of a rest after whole blocks and of points that do not stay.
struct Outcome {
  std::vector<float> points, times;
  std::size_t kept, not_finite;
};

Outcome outcome_of(MoveKernel kernel, Order order, std::size_t count,
                   const Layout& layout = kLayouts[0]) {
  // One motion, so that it hardly matters which of the two serves.
  const MotionSlot slots[2] = {
      {{1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3}, {0, 0, 1e-4F}, {0.5F, 0, 0.25F}},
      {{1, -1e-4F, 0, 1.4998F, 1e-4F, 1, 0, 2.0001F, 0, 0, 1, 3.25F},
       {0, 0, 1e-4F},
       {0.5F, 0, 0.25F}}};
  const KeepRule rule{4.0F,
                      4000.0F,
                      true,
                      {-9.0F, -9.0F, -9.0F},
                      {9.0F, 9.0F, 90.0F},
                      {1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F}};
  PointCloud cloud = cloud_in(order, count);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < count; i += 11) cloud.points[i].x = nan;
  for (std::size_t i = 5; i < count; i += 22) cloud.times[i] = nan;
  const std::vector<unsigned char> bytes = packed(cloud, layout);
  std::vector<float> points(4 * count), times(count);
  const MoveResult result =
      kernel({bytes.data() + kBefore, layout.step, layout.intensity, cloud.times.data(), count},
             {points.data(), times.data()}, rule, {slots, 2, -0.05F, 2.0F / 0.11F}, true);
  points.resize(4 * result.kept);
  times.resize(result.kept);
  return {points, times, result.kept, result.not_finite};
}

TEST(MoveKernel, KeepsTheOrderAndCountsNonFinitePoints) {
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 17U, 1001U}) {
    const Outcome outcome = outcome_of(move_kernel(), Order::kByTime, count);
    EXPECT_EQ(outcome.not_finite, (count + 10) / 11 + (count + 16) / 22) << count;
    EXPECT_LE(outcome.kept + outcome.not_finite, count);
    for (std::size_t i = 1; i < outcome.kept; ++i) {
      EXPECT_LT(outcome.points[4 * i - 1], outcome.points[4 * i + 3]);
      EXPECT_LT(outcome.times[i - 1], outcome.times[i]);
    }
  }
}

void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.times, b.times);
  EXPECT_EQ(a.not_finite, b.not_finite);
}

TEST(MoveKernel, ReadsAnyLayout) {
  const Outcome plain = outcome_of(portable_move_kernel(), Order::kByBeam, 1003);
  for (const Layout& layout : kLayouts) {
    expect_same(plain, outcome_of(portable_move_kernel(), Order::kByBeam, 1003, layout));
  }
}

TEST(MoveKernel, MovesInPlace) {
  const PointCloud raw = cloud_in(Order::kByBeam, 1003);
  PointCloud apart = raw, in_place = raw;
  const ScanMotion motion = fast_motion();
  keep_and_deskew(packed_in(raw), apart, Pose::Identity(), PassLimits({}), &motion);
  keep_and_deskew(packed_in(in_place), in_place, Pose::Identity(), PassLimits({}), &motion);
  ASSERT_EQ(apart.size(), in_place.size());
  EXPECT_EQ(apart.times, in_place.times);
  EXPECT_EQ(std::memcmp(apart.points.data(), in_place.points.data(), 16 * apart.size()), 0);
}

/// What is kept may differ where a point lies on a border; no point of these does.
void expect_close(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.times, b.times);
  EXPECT_EQ(a.not_finite, b.not_finite);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) ASSERT_NEAR(a.points[i], b.points[i], 1e-4);
}

TEST(MoveKernel, WiderInstructionsGiveTheSame) {
  if (avx2_move_kernel() == nullptr) GTEST_SKIP() << "no AVX2 here";
  for (const Order order : {Order::kByTime, Order::kByBeam, Order::kShuffled}) {
    for (const Layout& layout : kLayouts) {
      const Outcome portable = outcome_of(portable_move_kernel(), order, 1003, layout);
      EXPECT_GT(portable.kept, 300U);
      expect_close(portable, outcome_of(avx2_move_kernel(), order, 1003, layout));
      if (avx512_move_kernel() == nullptr) continue;
      expect_close(portable, outcome_of(avx512_move_kernel(), order, 1003, layout));
    }
  }
}

std::vector<MoveKernel> all_kernels() {
  std::vector<MoveKernel> kernels = {portable_move_kernel()};
  for (const MoveKernel kernel : {avx2_move_kernel(), avx512_move_kernel()})
    if (kernel != nullptr) kernels.push_back(kernel);
  return kernels;
}

// The box is on the vehicle: the motion must not carry points out of it or into it.
TEST(MoveKernel, ComparesMeasuredPointsWithTheBox) {
  const MotionSlot ahead = {{1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}, {0, 0, 0}, {0, 0, 0}};
  const KeepRule rule{0.0F,
                      1e6F,
                      true,
                      {-9.0F, -9.0F, -9.0F},
                      {9.0F, 9.0F, 90.0F},
                      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const PointCloud cloud = cloud_in(Order::kByTime, 1003);
  const std::vector<unsigned char> bytes = packed(cloud, kLayouts[0]);
  std::vector<float> expected;
  for (const Point& p : cloud.points) {
    const bool inside = std::abs(p.x) < 9.0F && std::abs(p.y) < 9.0F && p.z > -9.0F && p.z < 90.0F;
    if (!inside) expected.push_back(p.intensity);
  }
  ASSERT_LT(expected.size(), cloud.size());
  for (const MoveKernel kernel : all_kernels()) {
    for (const float* times : {static_cast<const float*>(nullptr), cloud.times.data()}) {
      std::vector<float> points(4 * cloud.size()), kept_times(cloud.size());
      const MoveResult result = kernel(
          {bytes.data() + kBefore, kLayouts[0].step, kLayouts[0].intensity, times, cloud.size()},
          {points.data(), kept_times.data()}, rule, {&ahead, 1, -0.05F, 1.0F / 0.11F}, true);
      EXPECT_EQ(result.not_finite, 0U);
      ASSERT_EQ(result.kept, expected.size());
      for (std::size_t i = 0; i < result.kept; ++i) EXPECT_EQ(points[4 * i + 3], expected[i]);
    }
  }
}

TEST(TimesKernel, CopiesAndFindsTheSpan) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t count : {1U, 7U, 8U, 1003U}) {
    for (const std::size_t step : {4U, 20U, 22U, 48U}) {
      std::vector<unsigned char> bytes(kBefore + step * count, 0xAB);
      std::vector<float> expected;
      for (std::size_t i = 0; i < count; ++i) {
        expected.push_back(i % 5 == 3 ? nan : static_cast<float>((7 * i + 1) % count) - 2.0F);
        std::memcpy(&bytes[kBefore + step * i], &expected.back(), sizeof(float));
      }
      for (const TimesKernel kernel : {portable_times_kernel(), times_kernel()}) {
        std::vector<float> times(count);
        const Bounds bounds =
            kernel({bytes.data() + kBefore, step, count}, times.data(), {0.0F, 0.0F});
        EXPECT_EQ(std::memcmp(times.data(), expected.data(), count * sizeof(float)), 0);
        Bounds by_hand{0.0F, 0.0F};
        for (const float time : expected) {
          by_hand.least = std::fmin(by_hand.least, time);
          by_hand.greatest = std::fmax(by_hand.greatest, time);
        }
        EXPECT_EQ(bounds.least, by_hand.least) << count << " " << step;
        EXPECT_EQ(bounds.greatest, by_hand.greatest) << count << " " << step;
      }
    }
  }
}

TEST(TimesKernel, FillsOldAndNewMemory) {
  std::vector<float> source(10000);
  std::iota(source.begin(), source.end(), 1.0F);
  const auto* first = reinterpret_cast<const unsigned char*>(source.data());
  for (const std::size_t before : {0U, 3000U, 20000U}) {
    std::vector<float> times(before, -1.0F);
    const TimeSpan span = read_times(first, sizeof(float), source.size(), times);
    EXPECT_EQ(times, source) << before;
    EXPECT_EQ(span.begin, 1.0);
    EXPECT_EQ(span.end, 10000.0);
  }
}

TEST(TimesKernel, NonFiniteTimesHaveNoSpan) {
  std::vector<float> times;
  const std::vector<float> none(9, std::numeric_limits<float>::quiet_NaN());
  const TimeSpan span =
      read_times(reinterpret_cast<const unsigned char*>(none.data()), sizeof(float), 9, times);
  EXPECT_EQ(span.begin, 0.0);
  EXPECT_EQ(span.end, 0.0);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
