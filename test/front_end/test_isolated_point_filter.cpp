// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_filter.hpp"

#include "evaluated_drive.hpp"
#include "scan/isolated_point_filter.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kScan = 60;

simulation::Drive corrupted_drive(const std::string& name, const std::string& lidar,
                                  const std::string& fault) {
  return faulty_drive(drive_options(name, 8.0, 3, lidar), fault);
}

/// Fractions of the made-up and of the true points that are left out.
struct LeftOut {
  double made_up = 0.0;
  double true_ones = 0.0;
};

LeftOut left_out(const simulation::Drive& drive, const simulation::Drive& clean) {
  const Scan scan = lidar_scan(drive, kScan);
  std::set<std::tuple<float, float, float>> true_places, kept_places;
  for (const Point& p : lidar_scan(clean, kScan).cloud.points) true_places.insert({p.x, p.y, p.z});
  IsolatedPointFilter filter;
  for (const Point& p : filter.without_isolated_points(scan).cloud.points)
    kept_places.insert({p.x, p.y, p.z});
  double made_up = 0.0, made_up_gone = 0.0, true_ones = 0.0, true_gone = 0.0;
  for (const Point& p : scan.cloud.points) {
    const bool is_true = true_places.count({p.x, p.y, p.z}) > 0;
    const bool is_gone = kept_places.count({p.x, p.y, p.z}) == 0;
    (is_true ? true_ones : made_up) += 1.0;
    if (is_gone) (is_true ? true_gone : made_up_gone) += 1.0;
  }
  return {made_up_gone / std::max(1.0, made_up), true_gone / std::max(1.0, true_ones)};
}

struct Case {
  const char* lidar;
  const char* fault;
  double made_up;    ///< at least
  double true_ones;  ///< at most
};

class ArtificialPoints : public testing::TestWithParam<Case> {};

TEST_P(ArtificialPoints, AreRemovedAndRealOnesAreKept) {
  const simulation::Drive drive = corrupted_drive("town", GetParam().lidar, GetParam().fault);
  const simulation::Drive clean = corrupted_drive("town", GetParam().lidar, "");
  const LeftOut found = left_out(drive, clean);
  EXPECT_GT(found.made_up, GetParam().made_up);
  EXPECT_LT(found.true_ones, GetParam().true_ones);
}

INSTANTIATE_TEST_SUITE_P(Scans, ArtificialPoints,
                         testing::Values(Case{"hdl64", "outliers=0.15", 0.9, 0.04},
                                         Case{"hdl64", "outliers=0.3", 0.9, 0.04},
                                         Case{"vlp16", "outliers=0.15", 0.9, 0.06},
                                         Case{"vlp16", "outliers=0.3", 0.9, 0.06}));

/// A clean scan must come back as the object that it was, as all that follows then stays the same.
TEST(IsolatedPointFilter, DoesNotChangeCleanScans) {
  for (const char* name : {"town", "walk", "open_road", "car_park"}) {
    for (const char* lidar : {"vlp16", "hdl64"}) {
      const simulation::Drive drive = corrupted_drive(name, lidar, "");
      IsolatedPointFilter filter;
      for (const std::size_t i : {0, 60}) {
        const Scan scan = lidar_scan(drive, i);
        EXPECT_EQ(&filter.without_isolated_points(scan), &scan) << name << " " << lidar << " " << i;
      }
      EXPECT_LT(filter.isolated_fraction(), 0.025) << name << " " << lidar;
    }
  }
}

/// Points that were thinned out before have no close neighbours and lie on surfaces all the same.
TEST(IsolatedPointFilter, DoesNotChangeThinnedOutScans) {
  const simulation::Drive drive = corrupted_drive("town", "hdl64", "");
  for (const double edge : {0.1, 0.25, 0.5}) {
    IsolatedPointFilter filter;
    Scan scan = lidar_scan(drive, kScan);
    scan.cloud = voxel_filtered(scan.cloud, edge);
    const std::size_t left = filter.without_isolated_points(scan).cloud.size();
    EXPECT_GT(static_cast<double>(left), 0.97 * static_cast<double>(scan.cloud.size())) << edge;
  }
  const simulation::Drive sparse = corrupted_drive("town", "hdl64", "sparse=1000");
  IsolatedPointFilter filter;
  const Scan scan = lidar_scan(sparse, kScan);
  EXPECT_GT(filter.without_isolated_points(scan).cloud.size(), 900U);
}

TEST(IsolatedPointFilter, KeepsTheTimesOfRemainingPoints) {
  const simulation::Drive drive = corrupted_drive("town", "vlp16", "outliers=0.2");
  IsolatedPointFilter filter;
  const Scan scan = lidar_scan(drive, kScan);
  const Scan& kept = filter.without_isolated_points(scan);
  ASSERT_LT(kept.cloud.size(), scan.cloud.size());
  ASSERT_EQ(kept.cloud.times.size(), kept.cloud.size());
  EXPECT_EQ(kept.stamp, scan.stamp);
  std::size_t i = 0;
  for (std::size_t k = 0; k < kept.cloud.size(); ++k, ++i) {
    while (scan.cloud.points[i].position() != kept.cloud.points[k].position()) ++i;
    ASSERT_EQ(kept.cloud.times[k], scan.cloud.times[i]);
  }
}

TEST(IsolatedPointFilter, HandlesEmptyAndInvalidClouds) {
  IsolatedPointFilter filter;
  Scan scan;
  EXPECT_TRUE(filter.without_isolated_points(scan).cloud.empty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 1000; ++i) {
    scan.cloud.points.push_back({nan, 1e30F, -1e30F, 0.0F});
    scan.cloud.points.push_back({0.0F, 0.0F, 0.0F, 0.0F});
  }
  EXPECT_EQ(filter.without_isolated_points(scan).cloud.size(), 2000U);
}

}  // namespace
}  // namespace lidar_mapping::front_end
