// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "ndt/ndt_kernels.hpp"
#include "ndt/ndt_parts.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

constexpr float kWideKernel = 1e9F;  // so that every point has full weight

/// A point of the sensor's frame and the upright normal that it is matched with. The squared length
/// of the normal is what the point adds to the translation's part of the Hessian.
struct Matched {
  Eigen::Vector3f p_sensor;
  float information = 1.0F;
};

Eigen::Vector3f at(double angle_deg, double range, float z = 0.0F) {
  const double angle = angle_deg * M_PI / 180.0;
  return {static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)),
          z};
}

/// Points, their planes, and the sums of both.
struct Scene {
  explicit Scene(const std::vector<Matched>& matched,
                 const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt) {
    std::vector<float> x, y, z;
    for (const Matched& one : matched) {
      x.push_back(one.p_sensor.x());
      y.push_back(one.p_sensor.y());
      z.push_back(one.p_sensor.z());
    }
    points.assign(x, y, z, std::vector<float>(x.size(), 0.0F), viewpoint);
    rotated.x = points.x();
    rotated.y = points.y();
    rotated.z = points.z();
    for (auto* array : {&planes.x, &planes.y, &planes.z, &planes.offset}) {
      array->resize(points.padded_size(), 0.0F);
    }
    // The points are of one instant, so that their order is that of the input.
    for (std::size_t i = 0; i < matched.size(); ++i) {
      planes.z[i] = std::sqrt(matched[i].information);
    }
  }

  NdtPoints points;
  RotatedPoints rotated;
  PlaneArrays planes;
};

std::vector<NdtPart> parts_of(const Scene& scene, NdtParts& parts) {
  return parts.of(scene.points, scene.rotated, scene.planes, kWideKernel,
                  Eigen::Matrix3d::Identity());
}
std::vector<NdtPart> parts_of(const Scene& scene) {
  NdtParts fresh;
  return parts_of(scene, fresh);
}

/// What the points of each part add to the vertical translation.
std::vector<double> information_of_parts(
    const std::vector<Matched>& matched,
    const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt) {
  std::vector<double> information;
  for (const NdtPart& part : parts_of(Scene(matched, viewpoint))) {
    information.push_back(std::round(1e3 * part.hessian(2, 2)) / 1e3);
  }
  return information;
}

/// The only part that has points; kNdtParts if there is not just one.
std::size_t only_part(const std::vector<Matched>& matched) {
  const std::vector<double> information = information_of_parts(matched);
  std::size_t only = kNdtParts;
  for (std::size_t part = 0; part < kNdtParts; ++part) {
    if (information[part] == 0.0) continue;
    if (only != kNdtParts) return kNdtParts;
    only = part;
  }
  return only;
}

TEST(NdtParts, AreSectorsOfFortyFiveDegrees) {
  std::vector<bool> used(kNdtParts, false);
  for (int sector = 0; sector < 8; ++sector) {
    const double begin = 45.0 * sector;
    const std::size_t part = only_part({{at(begin + 1.0, 10.0)}, {at(begin + 44.0, 10.0)}});
    ASSERT_LT(part, kNdtParts) << begin << ": both ends of a sector are one part";
    EXPECT_FALSE(used[part]) << begin;
    used[part] = true;
    EXPECT_EQ(only_part({{at(begin - 1.0, 10.0)}, {at(begin + 1.0, 10.0)}}), kNdtParts) << begin;
  }
}

// Neighbours in the list are neighbours around the sensor.
TEST(NdtParts, GoAroundTheSensor) {
  for (int sector = 0; sector < 8; ++sector) {
    const std::size_t here = only_part({{at(45.0 * sector + 20.0, 10.0)}}) % kNdtSectors;
    const std::size_t next = only_part({{at(45.0 * sector + 65.0, 10.0)}}) % kNdtSectors;
    EXPECT_EQ(next, (here + 1) % kNdtSectors) << sector;
  }
}

TEST(NdtParts, DivideASectorAtTheMeanRange) {
  // The mean range of the four is 10 m.
  const auto parts = information_of_parts({{at(10.0, 1.0), 1.0F},
                                           {at(20.0, 9.0), 2.0F},
                                           {at(30.0, 11.0), 4.0F},
                                           {at(100.0, 19.0), 8.0F}});
  const std::size_t first = only_part({{at(20.0, 1.0)}}) % kNdtSectors;
  const std::size_t second = only_part({{at(100.0, 1.0)}}) % kNdtSectors;
  EXPECT_EQ(parts[first], 3.0) << "the nearer ones";
  EXPECT_EQ(parts[kNdtSectors + first], 4.0) << "the farther one";
  EXPECT_EQ(parts[second], 0.0);
  EXPECT_EQ(parts[kNdtSectors + second], 8.0);
}

TEST(NdtParts, MeasureTheRangeAlongTheGround) {
  // Above each other, at the same distance from the axis of the sensor.
  EXPECT_LT(only_part({{at(10.0, 5.0, 0.0F)}, {at(20.0, 5.0, 40.0F)}}), kNdtParts);
}

TEST(NdtParts, LeaveOutPointsWithoutAPlane) {
  const std::vector<Matched> with_planes = {{at(10.0, 5.0), 1.0F}, {at(15.0, 9.0), 2.0F}};
  std::vector<Matched> with_others = with_planes;
  for (int i = 0; i < 20; ++i) with_others.push_back({at(18.0 * i, 500.0), 0.0F});
  EXPECT_EQ(information_of_parts(with_others), information_of_parts(with_planes))
      << "nor do they count in the mean range";
}

TEST(NdtParts, LieAroundTheSensorIfItsPlaceIsKnown) {
  std::vector<Matched> around;
  for (int i = 0; i < 24; ++i) {
    around.push_back({at(15.0 * i + 5.0, 4.0 + i), static_cast<float>(1 + i)});
  }
  std::vector<Matched> moved = around;
  const Eigen::Vector3f viewpoint(30.0F, -20.0F, 1.5F);
  for (Matched& one : moved) one.p_sensor += viewpoint;
  EXPECT_EQ(information_of_parts(moved, viewpoint), information_of_parts(around));
  EXPECT_NE(information_of_parts(moved), information_of_parts(around));
}

TEST(NdtParts, AreEmptyWithoutPoints) {
  const auto parts = parts_of(Scene({}));
  ASSERT_EQ(parts.size(), kNdtParts);
  for (const NdtPart& part : parts) {
    EXPECT_TRUE(part.hessian.isZero(0.0));
    EXPECT_TRUE(part.gradient.isZero(0.0));
  }
}

// An object is kept from scan to scan; its scratch memory must not show.
TEST(NdtParts, DoNotDependOnTheScanBefore) {
  std::vector<Matched> many;
  for (int i = 0; i < 100; ++i) many.push_back({at(3.6 * i, 2.0 + 0.3 * i), 1.0F});
  const Scene large(many);
  const Scene small({{at(10.0, 5.0), 1.0F}, {at(200.0, 9.0), 2.0F}});
  NdtParts reused;
  parts_of(large, reused);
  const auto again = parts_of(small, reused);
  const auto fresh = parts_of(small);
  for (std::size_t part = 0; part < kNdtParts; ++part) {
    EXPECT_EQ(again[part].hessian, fresh[part].hessian) << part;
    EXPECT_EQ(again[part].gradient, fresh[part].gradient) << part;
  }
}

/// Sums of one point of the map's axes, q = R p, that lies off its plane by r standard deviations.
NdtSums sums_of(const Eigen::Vector3d& q, const Eigen::Vector3d& normal, double r) {
  std::vector<float> values[7];
  const double numbers[7] = {
      q.x(), q.y(), q.z(), normal.x(), normal.y(), normal.z(), normal.dot(q) - r};
  for (std::size_t k = 0; k < 7; ++k) {
    values[k].assign(kNdtLanes, 0.0F);
    values[k][0] = static_cast<float>(numbers[k]);
  }
  const float* const planes[4] = {values[3].data(), values[4].data(), values[5].data(),
                                  values[6].data()};
  const float translation[3] = {};
  NdtSums sums{};
  portable_ndt_kernels().accumulate(values[0].data(), values[1].data(), values[2].data(), planes,
                                    translation, kWideKernel, kNdtLanes, &sums);
  return sums;
}

// A wall in front of the sensor says how far ahead it is, wherever that is in the map.
TEST(NdtPart, IsInTheAxesOfTheSensor) {
  const Eigen::Matrix3d R = exp_so3({0.2, -0.3, 2.0}).toRotationMatrix();
  const Eigen::Vector3d ahead(8.0, 0.0, 0.0), to_the_left(8.0, 2.0, 0.0);
  const Eigen::Vector3d facing = -Eigen::Vector3d::UnitX();
  const NdtPart part = part_of(sums_of(R * ahead, R * facing, 0.5), R);
  Matrix6d expected = Matrix6d::Zero();
  expected(0, 0) = 1.0;
  EXPECT_TRUE(test::near(part.hessian, expected, 1e-5));
  EXPECT_NEAR(part.gradient[0], -0.5, 1e-5) << "the wall is behind the point: forward is worse";
  // 2 m aside, a turn to the left by a small angle moves the point back by twice as many metres.
  const NdtPart aside = part_of(sums_of(R * to_the_left, R * facing, 0.5), R);
  EXPECT_NEAR(aside.hessian(5, 5), 4.0, 1e-4);
  EXPECT_NEAR(aside.hessian(0, 5), -2.0, 1e-4);
  EXPECT_NEAR(aside.gradient[5], 1.0, 1e-4);
  EXPECT_TRUE(test::near(aside.hessian, aside.hessian.transpose(), 1e-9));
}

}  // namespace
}  // namespace lidar_mapping::registration
