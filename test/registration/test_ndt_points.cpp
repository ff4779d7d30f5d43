// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"
#include "lidar_mapping/registration/ndt_points.hpp"

#include "ndt/ndt_kernels.hpp"

namespace lidar_mapping::registration {
namespace {

/// Points whose x is their number in the input, y and z multiples of it, with these times.
NdtPoints numbered(const std::vector<float>& times,
                   const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt) {
  std::vector<float> x, y, z;
  for (std::size_t i = 0; i < times.size(); ++i) {
    x.push_back(static_cast<float>(i));
    y.push_back(2.0F * static_cast<float>(i));
    z.push_back(-3.0F * static_cast<float>(i));
  }
  NdtPoints points;
  points.assign(x, y, z, times, viewpoint);
  return points;
}

std::vector<float> random_times(std::size_t count, float sweep = 0.1F) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<float> time(-0.5F * sweep, 0.5F * sweep);
  std::vector<float> times;
  while (times.size() < count) times.push_back(time(engine));
  return times;
}

/// Numbers in the input of those points of a slice that are no filling.
std::vector<std::size_t> numbers_of(const NdtPoints& points, const NdtPoints::Slice& slice) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = slice.begin; i < slice.end; ++i) {
    if (points.y()[i] == 2.0F * points.x()[i]) {
      numbers.push_back(static_cast<std::size_t>(points.x()[i]));
    }
  }
  return numbers;
}

std::vector<std::size_t> all_numbers(const NdtPoints& points) {
  std::vector<std::size_t> all;
  for (const NdtPoints::Slice& slice : points.slices()) {
    const auto own = numbers_of(points, slice);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

TEST(NdtPoints, HaveEveryPointOnceWithItsTime) {
  const std::vector<float> times = random_times(1003);
  const NdtPoints points = numbered(times);
  EXPECT_EQ(points.size(), times.size());
  std::vector<bool> found(times.size(), false);
  for (std::size_t i = 0; i < points.padded_size(); ++i) {
    if (points.y()[i] != 2.0F * points.x()[i]) continue;
    const auto number = static_cast<std::size_t>(points.x()[i]);
    EXPECT_FALSE(found.at(number)) << number;
    found[number] = true;
    EXPECT_EQ(points.z()[i], -3.0F * points.x()[i]) << number;
    EXPECT_EQ(points.s()[i], times[number]) << number;
  }
  EXPECT_EQ(std::count(found.begin(), found.end(), true), 1003);
}

TEST(NdtPoints, SlicesFollowEachOtherInTimeAndFillWholeLanes) {
  const std::vector<float> times = random_times(1003);
  const NdtPoints points = numbered(times);
  std::size_t end = 0;
  float latest = -std::numeric_limits<float>::infinity();
  for (const NdtPoints::Slice& slice : points.slices()) {
    EXPECT_EQ(slice.begin, end) << "no gap between slices";
    EXPECT_EQ((slice.end - slice.begin) % kNdtLanes, 0U);
    end = slice.end;
    const std::vector<std::size_t> numbers = numbers_of(points, slice);
    ASSERT_FALSE(numbers.empty());
    EXPECT_LT(slice.end - slice.begin - numbers.size(), kNdtLanes) << "no more than is needed";
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end())) << "the order of the input";
    double sum = 0.0;
    float earliest = std::numeric_limits<float>::infinity();
    const float before = latest;
    for (const std::size_t number : numbers) {
      earliest = std::min(earliest, times[number]);
      latest = std::max(latest, times[number]);
      sum += times[number];
    }
    EXPECT_GE(earliest, before);
    EXPECT_NEAR(slice.time, sum / static_cast<double>(numbers.size()), 1e-7);
  }
  EXPECT_EQ(end, points.padded_size());
}

// At 20 m/s a vehicle moves by 12 cm within 6 ms: what one pose stands for in a sweep of 0.1 s.
TEST(NdtPoints, SlicesOfASweepAreSixMillisecondsLong) {
  const std::vector<float> times = random_times(5000);
  const NdtPoints points = numbered(times);
  EXPECT_EQ(points.slices().size(), 16U);
  for (const NdtPoints::Slice& slice : points.slices()) {
    float earliest = 1.0F, latest = -1.0F;
    for (const std::size_t number : numbers_of(points, slice)) {
      earliest = std::min(earliest, times[number]);
      latest = std::max(latest, times[number]);
    }
    EXPECT_LT(latest - earliest, 0.0063F);
    EXPECT_GT(latest - earliest, 0.0055F);
  }
}

TEST(NdtPoints, PointsOfOneInstantAreOneSlice) {
  const NdtPoints points = numbered(std::vector<float>(20, 0.25F));
  ASSERT_EQ(points.slices().size(), 1U);
  EXPECT_EQ(points.slices().front().time, 0.25F);
  EXPECT_EQ(points.size(), 20U);
  EXPECT_EQ(points.padded_size(), 24U);
}

// A sensor that stops for half of the time, or two bursts of points.
TEST(NdtPoints, HaveNoSliceWithoutPoints) {
  std::vector<float> times(10, 0.0F);
  times.resize(20, 0.1F);
  const NdtPoints points = numbered(times);
  ASSERT_EQ(points.slices().size(), 2U);
  EXPECT_EQ(points.slices()[0].time, 0.0F);
  EXPECT_EQ(points.slices()[1].time, 0.1F) << "the last instant belongs to the last slice";
}

TEST(NdtPoints, MayBeNoneOrOne) {
  const NdtPoints none = numbered({}, Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(none.size(), 0U);
  EXPECT_EQ(none.padded_size(), 0U);
  EXPECT_TRUE(none.slices().empty());
  EXPECT_EQ(none.viewpoint(), Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  const NdtPoints one = numbered({0.03F});
  EXPECT_EQ(one.size(), 1U);
  EXPECT_EQ(one.padded_size(), kNdtLanes);
  EXPECT_FALSE(one.viewpoint().has_value());
}

TEST(NdtPoints, DiscardPreviousPoints) {
  NdtPoints points = numbered(random_times(500), Eigen::Vector3f(1.0F, 0.0F, 0.0F));
  const std::vector<float> one = {7.0F}, two = {14.0F}, three = {-21.0F}, time = {0.5F};
  points.assign(one, two, three, time);
  EXPECT_EQ(points.size(), 1U);
  ASSERT_EQ(points.slices().size(), 1U);
  EXPECT_EQ(numbers_of(points, points.slices().front()), std::vector<std::size_t>{7});
  EXPECT_FALSE(points.viewpoint().has_value());
}

// The filling must not be matched, however large the voxels are: it would count as points.
TEST(NdtPoints, FillingMatchesNothing) {
  for (const double resolution : {0.3, 1.0, 100.0}) {
    GaussianVoxelMap map(resolution, 64);
    std::vector<float> x, y;
    for (int i = 0; i < 9; ++i) {
      x.push_back(static_cast<float>(resolution) * (0.2F + 0.3F * static_cast<float>(i / 3)));
      y.push_back(static_cast<float>(resolution) * (0.2F + 0.3F * static_cast<float>(i % 3)));
    }
    std::vector<float> z(9, 0.5F * static_cast<float>(resolution));
    map.insert(x.data(), y.data(), z.data(), 9);
    // Eight more points where there is nothing.
    for (auto* array : {&x, &y, &z}) array->resize(17, 5.5F * static_cast<float>(resolution));
    NdtPoints points;
    points.assign(x, y, z, std::vector<float>(17, 0.0F));
    ASSERT_EQ(points.padded_size(), 24U);
    const NdtMatch match = NdtMatcher().evaluate(points, map, MotionState{}, NdtOptions{});
    EXPECT_NEAR(match.overlap, 9.0 / 17.0, 1e-6) << resolution;
  }
}

TEST(NdtPoints, ThinnedHaveEveryNthInTheOrderOfTime) {
  const NdtPoints points = numbered(random_times(1003), Eigen::Vector3f(0.0F, 0.0F, 2.0F));
  const std::vector<std::size_t> all = all_numbers(points);
  for (const std::size_t step : {1U, 3U, 7U, 2000U}) {
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < all.size(); i += step) expected.push_back(all[i]);
    NdtPoints thinned = numbered({0.1F, 0.2F});
    thinned.assign_thinned(points, step);
    EXPECT_EQ(all_numbers(thinned), expected) << step;
    EXPECT_EQ(thinned.size(), expected.size()) << step;
    EXPECT_EQ(thinned.padded_size() % kNdtLanes, 0U) << step;
    EXPECT_EQ(thinned.viewpoint(), points.viewpoint()) << step;
  }
}

TEST(NdtPoints, ThinnedToHalfTwiceAreAQuarter) {
  const NdtPoints points = numbered(random_times(1003));
  NdtPoints half, quarter_of_half, quarter;
  half.assign_thinned(points, 2);
  quarter_of_half.assign_thinned(half, 2);
  quarter.assign_thinned(points, 4);
  EXPECT_EQ(all_numbers(quarter_of_half), all_numbers(quarter));
}

}  // namespace
}  // namespace lidar_mapping::registration
