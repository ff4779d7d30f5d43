// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "visibility/range_image.hpp"

namespace lidar_mapping::moving_objects {
namespace {

/// What a scan says about a location.
enum class Seen { kNothing, kThrough, kHit };

/// Looks at locations through an image, each from the sensor's place.
std::vector<Seen> seen_at(const RangeImage& image, const Eigen::Vector3f& sensor,
                          const std::vector<Eigen::Vector3f>& locations) {
  const std::size_t count = locations.size();
  Viewpoint view{{1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F},
                 {sensor.x(), sensor.y(), sensor.z()},
                 100.0F * 100.0F,
                 image.first_row(),
                 image.rows()};
  std::vector<float> x, y, z;
  for (const Eigen::Vector3f& p : locations) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
  std::vector<int> pixels(count), nearest(count), farthest(count), remaining(count);
  std::vector<int> through(count), hits(count), ambiguous(count);
  const ProjectedPixels targets = {pixels.data(), nearest.data(), farthest.data()};
  visibility_kernels().project_into_view(view, {x.data(), y.data(), z.data()}, count, targets,
                                         remaining.data());
  image.classify(targets, count, {through.data(), hits.data()}, ambiguous.data());
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_LE(through[i] + hits[i], 1) << i;
    seen.push_back(through[i] > 0 ? Seen::kThrough : hits[i] > 0 ? Seen::kHit : Seen::kNothing);
  }
  return seen;
}

Seen seen_at(const PointCloud& cloud, const Eigen::Vector3f& location) {
  const Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  return seen_at(RangeImage(cloud, origin), origin, {location}).front();
}

/// A point at these angles (degrees) and this range (m).
Eigen::Vector3f at(double azimuth, double elevation, double range) {
  const double a = azimuth * M_PI / 180.0;
  const double e = elevation * M_PI / 180.0;
  return Eigen::Vector3d(range * std::cos(e) * std::cos(a), range * std::cos(e) * std::sin(a),
                         range * std::sin(e))
      .cast<float>();
}

void add(PointCloud& cloud, const Eigen::Vector3f& p) {
  cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
}

/// A piece of a sphere around the sensor, dense enough to fill every pixel.
void add_patch(PointCloud& cloud, double azimuth, double width, double range,
               double height = 10.0) {
  for (double a = azimuth - 0.5 * width; a <= azimuth + 0.5 * width; a += 0.1) {
    for (double e = -0.5 * height; e <= 0.5 * height; e += 0.1) add(cloud, at(a, e, range));
  }
}

PointCloud wall_at(double azimuth, double range) {
  PointCloud cloud;
  add_patch(cloud, azimuth, 20.0, range);
  return cloud;
}

TEST(RangeImage, IsSeenThroughInFrontOfWhatWasHit) {
  for (const double azimuth : {0.0, 37.0, 90.0, 180.0, -90.0}) {
    const PointCloud wall = wall_at(azimuth, 20.0);
    EXPECT_EQ(seen_at(wall, at(azimuth, 0.0, 10.0)), Seen::kThrough) << azimuth;
    EXPECT_EQ(seen_at(wall, at(azimuth, 0.0, 20.0)), Seen::kHit) << azimuth;
    EXPECT_EQ(seen_at(wall, at(azimuth, 0.0, 30.0)), Seen::kNothing) << azimuth << ": hidden";
    EXPECT_EQ(seen_at(wall, at(azimuth + 180.0, 0.0, 10.0)), Seen::kNothing) << "no beam";
    EXPECT_EQ(seen_at(wall, at(azimuth, 30.0, 10.0)), Seen::kNothing) << "above the image";
    EXPECT_EQ(seen_at(wall, at(azimuth, -30.0, 10.0)), Seen::kNothing) << "below the image";
  }
}

// A beam that passes a pole on one side does not tell that the pole is gone.
TEST(RangeImage, IsNotSeenThroughBesideAnObject) {
  PointCloud cloud = wall_at(0.0, 20.0);
  add_patch(cloud, 0.2, 0.2, 8.0);  // within the pixel from 0 to 0.4 degrees
  const auto behind = [&](double azimuth) { return seen_at(cloud, at(azimuth, 0.0, 14.0)); };
  EXPECT_EQ(behind(0.2), Seen::kNothing);
  EXPECT_EQ(behind(-0.2), Seen::kNothing) << "one pixel aside";
  EXPECT_EQ(behind(0.6), Seen::kNothing);
  EXPECT_EQ(behind(-0.6), Seen::kThrough) << "two pixels aside";
  EXPECT_EQ(behind(1.0), Seen::kThrough);
  EXPECT_EQ(seen_at(cloud, at(0.6, 0.0, 8.0)), Seen::kHit) << "the pole is there";
  EXPECT_EQ(seen_at(cloud, at(1.0, 0.0, 8.0)), Seen::kThrough);
}

TEST(RangeImage, IsNotSeenThroughAboveAnObject) {
  PointCloud cloud = wall_at(0.0, 20.0);
  for (double a = -8.0; a < 8.0; a += 0.1) add(cloud, at(a, -1.75, 8.0));  // a kerb
  const auto behind = [&](double elevation) { return seen_at(cloud, at(0.0, elevation, 14.0)); };
  EXPECT_EQ(behind(-1.75), Seen::kNothing);
  EXPECT_EQ(behind(-1.25), Seen::kNothing) << "one pixel above";
  EXPECT_EQ(behind(-2.25), Seen::kNothing) << "one pixel below";
  EXPECT_EQ(behind(-0.75), Seen::kThrough);
  EXPECT_EQ(behind(-2.75), Seen::kThrough);
}

// Behind the sensor the columns begin and end.
TEST(RangeImage, WrapsAroundInAzimuth) {
  for (const double side : {-1.0, 1.0}) {
    PointCloud cloud = wall_at(180.0, 20.0);
    add_patch(cloud, 180.0 + 0.2 * side, 0.2, 8.0);
    const auto seen = [&](double aside, double range) {
      return seen_at(cloud, at(180.0 + aside * side, 0.0, range));
    };
    EXPECT_EQ(seen(-0.2, 14.0), Seen::kNothing) << "on the other side of the border";
    EXPECT_EQ(seen(-0.2, 8.0), Seen::kHit);
    EXPECT_EQ(seen(-0.6, 14.0), Seen::kThrough);
    EXPECT_EQ(seen(-0.6, 8.0), Seen::kThrough);
  }
}

TEST(RangeImage, IsNotHitBetweenAnObjectAndTheWallBehindIt) {
  PointCloud cloud = wall_at(0.0, 20.0);
  add_patch(cloud, 0.0, 10.0, 8.0);
  EXPECT_EQ(seen_at(cloud, at(0.0, 0.0, 8.0)), Seen::kHit);
  EXPECT_EQ(seen_at(cloud, at(0.0, 0.0, 14.0)), Seen::kNothing);
  EXPECT_EQ(seen_at(cloud, at(0.0, 0.0, 20.0)), Seen::kHit);
  EXPECT_EQ(seen_at(cloud, at(0.0, 0.0, 4.0)), Seen::kThrough);
}

// Three ranges in the window: the one in the middle counts as well.
TEST(RangeImage, IsHitByAnyPixelOfTheWindow) {
  PointCloud cloud;
  add_patch(cloud, 0.2, 0.2, 8.0);
  add_patch(cloud, 0.6, 0.2, 14.0);
  add_patch(cloud, 1.0, 0.2, 20.0);
  EXPECT_EQ(seen_at(cloud, at(0.6, 0.0, 14.0)), Seen::kHit);
  EXPECT_EQ(seen_at(cloud, at(0.6, 0.0, 8.0)), Seen::kHit);
  EXPECT_EQ(seen_at(cloud, at(0.6, 0.0, 20.0)), Seen::kHit);
  EXPECT_EQ(seen_at(cloud, at(0.6, 0.0, 11.0)), Seen::kNothing);
}

// Also by one on the other side of where the columns begin and end.
TEST(RangeImage, IsHitByAPixelBeyondTheBorder) {
  for (const double side : {-1.0, 1.0}) {
    PointCloud cloud;
    add_patch(cloud, 180.0 - 0.6 * side, 0.2, 20.0);
    add_patch(cloud, 180.0 - 0.2 * side, 0.2, 8.0);
    add_patch(cloud, 180.0 + 0.2 * side, 0.2, 14.0);
    EXPECT_EQ(seen_at(cloud, at(180.0 - 0.2 * side, 0.0, 14.0)), Seen::kHit) << side;
    EXPECT_EQ(seen_at(cloud, at(180.0 - 0.2 * side, 0.0, 11.0)), Seen::kNothing) << side;
  }
}

TEST(RangeImage, IsSeenThroughUpToItsFarthestRange) {
  EXPECT_EQ(seen_at(wall_at(0.0, 500.0), at(0.0, 0.0, 90.0)), Seen::kThrough);
  EXPECT_EQ(seen_at(wall_at(0.0, 500.0), at(0.0, 0.0, 110.0)), Seen::kNothing) << "out of range";
}

TEST(RangeImage, HasNoRowsWithoutPoints) {
  PointCloud invalid;
  add(invalid, {std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F});
  add(invalid, {0.0F, std::numeric_limits<float>::infinity(), 0.0F});
  for (const PointCloud& cloud : {PointCloud(), invalid}) {
    EXPECT_EQ(RangeImage(cloud, Eigen::Vector3f::Zero()).rows(), 0);
    EXPECT_EQ(seen_at(cloud, {5.0F, 0.0F, 0.0F}), Seen::kNothing);
  }
}

/// Everything around a sensor at random ranges, and locations to look at.
struct Surroundings {
  Surroundings() {
    std::mt19937 engine(8);
    std::uniform_real_distribution<double> azimuth(-180.0, 180.0), elevation(-15.0, 15.0);
    std::uniform_real_distribution<double> range(3.0, 60.0);
    for (int i = 0; i < 40; ++i) add_patch(cloud, azimuth(engine), 12.0, range(engine), 20.0);
    for (std::size_t i = 0; i < 2000; ++i) {
      locations.push_back(at(azimuth(engine), elevation(engine), range(engine)));
      locations.push_back(cloud.points[i * cloud.size() / 2000].position());
    }
  }
  std::vector<Seen> seen() const { return seen_at(RangeImage(cloud, sensor), sensor, locations); }

  PointCloud cloud;
  std::vector<Eigen::Vector3f> locations;
  Eigen::Vector3f sensor = Eigen::Vector3f::Zero();
};

TEST(RangeImage, DoesNotDependOnTheOrderOfThePoints) {
  Surroundings surroundings;
  const std::vector<Seen> seen = surroundings.seen();
  for (const Seen kind : {Seen::kNothing, Seen::kThrough, Seen::kHit}) {
    EXPECT_GT(std::count(seen.begin(), seen.end(), kind), 100);
  }
  std::shuffle(surroundings.cloud.points.begin(), surroundings.cloud.points.end(), std::mt19937(1));
  EXPECT_EQ(surroundings.seen(), seen);
  add(surroundings.cloud, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_EQ(surroundings.seen(), seen) << "a point that is none changes nothing";
}

// By a power of two, so that the differences are exact but for the last bit of the coordinates.
TEST(RangeImage, MovesWithTheSensor) {
  Surroundings surroundings;
  const std::vector<Seen> seen = surroundings.seen();
  surroundings.sensor = {8.0F, -16.0F, 4.0F};
  for (Point& p : surroundings.cloud.points) {
    p.x += 8.0F;
    p.y -= 16.0F;
    p.z += 4.0F;
  }
  for (Eigen::Vector3f& p : surroundings.locations) p += surroundings.sensor;
  const std::vector<Seen> moved = surroundings.seen();
  std::size_t same = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) same += moved[i] == seen[i] ? 1U : 0U;
  EXPECT_GT(same, seen.size() * 99 / 100) << "all but some on borders of pixels";
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
