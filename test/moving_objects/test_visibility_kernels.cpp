// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "visibility/visibility_kernels.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr std::size_t kCount = 203;  // not a multiple of the lanes
constexpr int kRows = 60;
constexpr int kFirstRow = 330;

struct Points {
  /// Every tenth point is NaN or on an axis of the sensor.
  Points() : x(kCount), y(kCount), z(kCount) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<float> uniform(-45.0F, 45.0F);
    for (std::size_t i = 0; i < kCount; ++i) {
      x[i] = uniform(engine);
      y[i] = uniform(engine);
      z[i] = 0.3F * uniform(engine);
      if (i % 30 == 0) x[i] = std::numeric_limits<float>::quiet_NaN();
      if (i % 30 == 10) x[i] = y[i] = 0.0F;
      if (i % 30 == 20) y[i] = z[i] = 0.0F;
    }
  }

  PointArrays arrays() const { return {x.data(), y.data(), z.data()}; }

  std::vector<float> x, y, z;
};

Viewpoint some_viewpoint() {
  const float s = std::sin(0.3F), c = std::cos(0.3F);
  return {
      {c, -s, 0.0F, s, c, 0.0F, 0.0F, 0.0F, 1.0F}, {3.0F, -2.0F, 1.8F}, 1600.0F, kFirstRow, kRows};
}

/// Ranges of up to 60 m, some of them unobserved.
std::vector<RangeInterval> some_windows() {
  std::mt19937 engine(6);
  std::uniform_int_distribution<RangeInterval> nearest(1, 30'000), more(0, 2000);
  std::vector<RangeInterval> windows;
  for (int i = 0; i < kRows * kRangeImageColumns; ++i) {
    const RangeInterval first = nearest(engine);
    windows.push_back(i % 7 == 0 ? kUnobserved : (first + more(engine)) << 16U | first);
  }
  windows.push_back(kUnobserved);
  return windows;
}

/// All results of the kernels for the same points.
std::vector<std::vector<int>> results_of(const VisibilityKernels& kernels) {
  const Points points;
  std::vector<std::vector<int>> results(12, std::vector<int>(kCount, 5));
  const auto to = [&](std::size_t i) { return results[i].data(); };
  kernels.project(points.arrays(), kCount, to(0), to(1), to(2));
  results[11][0] = kernels.count_in_range(some_viewpoint(), points.arrays(), kCount, to(3));
  const ProjectedPixels targets = {to(4), to(5), to(6)};
  kernels.project_into_view(some_viewpoint(), points.arrays(), kCount, targets, to(7));
  kernels.classify(some_windows().data(), targets, kCount, {to(8), to(9)}, to(10));
  return results;
}

TEST(VisibilityKernels, ProjectDirectionsToPixels) {
  const Points points;
  const auto results = results_of(portable_visibility_kernels());
  for (std::size_t i = 0; i < kCount; ++i) {
    const double x = points.x[i], y = points.y[i], z = points.z[i];
    if (std::isnan(x)) continue;
    const double column = (std::atan2(y, x) + M_PI) * kRangeImageColumns / (2.0 * M_PI);
    const double row = (std::atan2(z, std::hypot(x, y)) + M_PI) * 360.0 / M_PI;
    const double off = results[0][i] + 0.5 - column;
    EXPECT_LT(std::abs(std::remainder(off, kRangeImageColumns)), 0.51) << i;
    EXPECT_NEAR(results[1][i] + 0.5, row, 0.51) << i;
    EXPECT_NEAR(results[2][i], kUnitsPerMeter * std::hypot(x, y, z), 1.01) << i;
  }
}

TEST(VisibilityKernels, EvaluateOnlyPointsInRange) {
  const Points points;
  const auto results = results_of(portable_visibility_kernels());
  const Viewpoint view = some_viewpoint();
  for (std::size_t i = 0; i < kCount; ++i) {
    const double distance = std::hypot(points.x[i] - 3.0, points.y[i] + 2.0, points.z[i] - 1.8);
    const bool in_range = distance <= 40.0;
    EXPECT_EQ(results[3][i], in_range ? 6 : 5) << i;
    EXPECT_EQ(results[7][i], in_range ? 4 : 5) << i;
    EXPECT_TRUE(in_range || results[4][i] == view.no_pixel()) << i;
  }
}

TEST(VisibilityKernels, ClassifyWindows) {
  const auto interval = [](RangeInterval nearest, RangeInterval farthest) {
    return farthest << 16U | nearest;
  };
  // The window lies behind the location; in front of it; its nearest or its farthest range lies
  // there; it encloses it; it is unobserved.
  const std::vector<RangeInterval> windows = {interval(1201, 9000), interval(100, 999),
                                              interval(1000, 9000), interval(100, 1200),
                                              interval(100, 9000),  kUnobserved};
  std::vector<int> pixels = {0, 1, 2, 3, 4, 5}, nearest(6, 1000), farthest(6, 1200);
  std::vector<int> through(6), hits(6), ambiguous(6);
  portable_visibility_kernels().classify(windows.data(),
                                         {pixels.data(), nearest.data(), farthest.data()}, 6,
                                         {through.data(), hits.data()}, ambiguous.data());
  EXPECT_EQ(through, (std::vector<int>{1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(hits, (std::vector<int>{0, 0, 1, 1, 0, 0}));
  EXPECT_EQ(ambiguous, (std::vector<int>{0, 0, 0, 0, 1, 0}));
}

TEST(VisibilityKernels, CountPointsInRange) {
  const Points points;
  std::vector<int> counts(kCount);
  const int sum = portable_visibility_kernels().count_in_range(some_viewpoint(), points.arrays(),
                                                               kCount, counts.data());
  EXPECT_GT(sum, 0);
  EXPECT_EQ(sum, std::accumulate(counts.begin(), counts.end(), 0));
}

TEST(VisibilityKernels, AreEqualWithAvx2) {
  if (avx2_visibility_kernels() == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  EXPECT_EQ(results_of(*avx2_visibility_kernels()), results_of(portable_visibility_kernels()));
}

TEST(VisibilityKernels, AreEqualWithAvx512) {
  if (avx512_visibility_kernels() == nullptr)
    GTEST_SKIP() << "this processor is not fast with AVX-512";
  EXPECT_EQ(results_of(*avx512_visibility_kernels()), results_of(portable_visibility_kernels()));
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
