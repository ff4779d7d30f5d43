// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "map_matcher.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using loop_closing::test::Box;

/// A matched point in the map.
struct Seen {
  Eigen::Vector3d p_map;
  float agreement;
};

/// A town whose map was made before a lorry was parked in the street.
class ParkedLorry : public testing::Test {
 protected:
  ParkedLorry() : world_(make_town(100.0, 48.0, 3)), surfaces_(1 << 17) {
    for (const Pose& pose : along({{-60.0, 0.0}, {60.0, 0.0}})) {
      surfaces_.insert(world_.scan(pose, 1), pose, ToyWorld::sensor());
    }
    world_.boxes.push_back(lorry_);
  }

  /// The points of a scan from six metres before the lorry.
  std::vector<Seen> scan() {
    const Pose T_map_base = planar(6.0, 0.0, 0.0);
    const ScanPoints points =
        ScanPointSampler().sample(world_.scan(T_map_base, 9), ToyWorld::sensor());
    std::vector<Seen> seen;
    for (const MatchedPoint& point : MapMatcher().weighted(points, surfaces_, T_map_base)) {
      seen.push_back({T_map_base * point.p_base.cast<double>(), point.agreement});
    }
    EXPECT_EQ(seen.size(), points.all.size());
    return seen;
  }
  /// Whether a point lies on the lorry, above what may count as the ground.
  bool is_of_lorry(const Seen& seen) const {
    constexpr double kNoise = 0.15;  // m; chosen: more than seven times that of the points
    const Eigen::Vector3d nearest = seen.p_map.cwiseMax(lorry_.low).cwiseMin(lorry_.high);
    return seen.p_map.z() > 0.3 && (seen.p_map - nearest).norm() < kNoise;
  }
  bool is_of_near_wall(const Seen& seen) const {
    return seen.p_map.z() > 1.0 && seen.p_map.norm() < 25.0 && !is_of_lorry(seen);
  }

 private:
  const Box lorry_{{12.0, 3.0, 0.0}, {18.0, 4.8, 2.5}};
  ToyWorld world_;
  MapSurfaces surfaces_;
};

std::vector<Seen> those_that(const std::vector<Seen>& all,
                             const std::function<bool(const Seen&)>& are_wanted) {
  std::vector<Seen> wanted;
  std::copy_if(all.begin(), all.end(), std::back_inserter(wanted), are_wanted);
  return wanted;
}

bool is_known(const Seen& seen) { return seen.agreement != kNotInMap; }

double mean_agreement(const std::vector<Seen>& points) {
  double sum = 0.0;
  for (const Seen& seen : points) sum += seen.agreement;
  return sum / static_cast<double>(points.size());
}

TEST_F(ParkedLorry, AgreesWithNothingThatTheMapHas) {
  const auto lorry = those_that(scan(), [this](const Seen& seen) { return is_of_lorry(seen); });
  ASSERT_GT(lorry.size(), 10U);
  const auto known = those_that(lorry, is_known);
  EXPECT_LT(known.size(), lorry.size());
  for (const Seen& seen : lorry) {
    if (seen.p_map.z() < 1.05) continue;  // the voxels of the ground end at 1 m
    EXPECT_EQ(seen.agreement, kNotInMap) << seen.p_map.transpose();
  }
  ASSERT_FALSE(known.empty());  // what is near the ground lies in its voxels
  EXPECT_LT(mean_agreement(known), 0.2);
}

TEST_F(ParkedLorry, LeavesTheAgreementOfWallsAsItIs) {
  const auto walls = those_that(scan(), [this](const Seen& seen) { return is_of_near_wall(seen); });
  ASSERT_GT(walls.size(), 30U);
  const auto known = those_that(walls, is_known);
  EXPECT_GT(2 * known.size(), walls.size());
  EXPECT_GT(mean_agreement(known), 0.5);
}

}  // namespace
}  // namespace lidar_mapping::localization::test
