// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "points/sweep_seam.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;

/// Posts behind the sensor after it has driven `way` metres; they are farther apart than any way
/// between two sweeps.
std::vector<Eigen::Vector3f> posts(double way, int count) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(static_cast<float>(-10.0 - way), 3.0F * static_cast<float>(i) - 9.0F, 1.0F);
  }
  return points;
}

/// Drives, and adds a sweep for each letter: 'r' a raw one, 'c' a compensated one, 'b' a raw one
/// whose times run backwards.
struct Sweeps {
  double way_per_sweep = 1.0;  // m
  double period = 0.1;         // s, between the stamps of sweeps of 0.1 s
  int posts_in_view = 6;

  SweepSeam of(const std::string& kinds) const {
    SweepSeam seam;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      const auto number = static_cast<double>(i);
      CloudSummary cloud;
      cloud.stamp = at(period * number);
      cloud.last_time = 0.1;
      cloud.begin_points = posts(way_per_sweep * number, posts_in_view);
      // In a compensated sweep all points are seen from where it began.
      const double end = kinds[i] == 'c' ? number : number + 1.0;
      cloud.end_points = posts(way_per_sweep * end, posts_in_view);
      if (kinds[i] == 'b') std::swap(cloud.begin_points, cloud.end_points);
      seam.add(cloud);
    }
    return seam;
  }
};

std::string sweeps(std::size_t count, char kind) { return std::string(count, kind); }

TEST(SweepSeam, IsCompensatedAfterTenSeams) {
  EXPECT_FALSE(Sweeps().of(sweeps(10, 'c')).is_compensated()) << "nine seams";
  EXPECT_TRUE(Sweeps().of(sweeps(11, 'c')).is_compensated());
}

TEST(SweepSeam, OfRawSweepsJoinsTheNextOne) {
  EXPECT_FALSE(Sweeps().of(sweeps(40, 'r')).is_compensated());
}

TEST(SweepSeam, OfTimesThatRunBackwardsJoinsTheOtherWayRound) {
  Sweeps drive;
  drive.way_per_sweep = 0.3;  // so near that the ends of one sweep fit each other, too
  EXPECT_TRUE(drive.of(sweeps(11, 'b')).is_reversed());
  EXPECT_FALSE(drive.of(sweeps(40, 'b')).is_compensated());
  EXPECT_FALSE(drive.of(sweeps(10, 'b')).is_reversed()) << "nine seams";
  EXPECT_FALSE(drive.of(sweeps(40, 'r')).is_reversed());
  EXPECT_FALSE(drive.of(sweeps(40, 'c')).is_reversed());
}

// Each letter but the last one has a seam. Ten are more than four times two, and less than four
// times three.
TEST(SweepSeam, IsCompensatedOnlyIfHardlyAnyScanIsRaw) {
  EXPECT_TRUE(Sweeps().of(sweeps(10, 'c') + sweeps(2, 'r') + "c").is_compensated());
  EXPECT_FALSE(Sweeps().of(sweeps(10, 'c') + sweeps(3, 'r') + "c").is_compensated());
}

TEST(SweepSeam, ShowsNothingAtLowSpeed) {
  Sweeps slow;
  slow.way_per_sweep = 0.14;
  EXPECT_FALSE(slow.of(sweeps(40, 'c')).is_compensated());
  slow.way_per_sweep = 0.2;
  EXPECT_TRUE(slow.of(sweeps(40, 'c')).is_compensated());
}

TEST(SweepSeam, NeedsFourPoints) {
  Sweeps few;
  few.posts_in_view = 3;
  EXPECT_FALSE(few.of(sweeps(40, 'c')).is_compensated());
  few.posts_in_view = 4;
  EXPECT_TRUE(few.of(sweeps(40, 'c')).is_compensated());
}

TEST(SweepSeam, IsNotSoughtAcrossALostSweep) {
  Sweeps with_gaps;
  with_gaps.period = 0.2;
  EXPECT_FALSE(with_gaps.of(sweeps(40, 'c')).is_compensated());
  with_gaps.period = 0.14;
  EXPECT_TRUE(with_gaps.of(sweeps(40, 'c')).is_compensated());
}

// Beyond 50 m neighbouring points are too far apart, and nearer than 3 m is the vehicle.
TEST(SweepSeam, LooksOnlyAtPointsFromThreeToFiftyMetres) {
  for (const double range : {2.0, 4.0, 45.0, 60.0}) {
    SweepSeam seam;
    for (int i = 0; i < 20; ++i) {
      CloudSummary cloud;
      cloud.stamp = at(0.1 * i);
      cloud.last_time = 0.1;
      // All that is seen lies a metre to the side of where it was in the sweep before.
      const auto side = static_cast<float>(i % 2);
      for (int k = 0; k < 6; ++k) {
        cloud.begin_points.emplace_back(static_cast<float>(range), side,
                                        0.01F * static_cast<float>(k));
      }
      cloud.end_points = cloud.begin_points;
      seam.add(cloud);
    }
    EXPECT_EQ(seam.is_compensated(), range > 3.0 && range < 50.0) << range;
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
