// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

namespace lidar_mapping::map_quality {
namespace {

constexpr KeyFrameIndex kPerPass = 15;
constexpr double kNoise = 0.02;

/// A street with house fronts, cross walls and ground that was driven through twice; in between the
/// vehicle is far away. Points are random on the surfaces, with range noise along the beam.
class TwoPasses : public CloudSource {
 public:
  explicit TwoPasses(const Pose& displacement) {
    std::mt19937 random(5);
    for (KeyFrameIndex index = 0; index < 2 * kPerPass; ++index) {
      Pose truth;
      truth.translation.x() = 2.0 * (index % kPerPass);
      Pose mapped = truth;
      if (index >= kPerPass) mapped = displacement * truth;
      clouds_[index] = scan(truth, random);
      poses.poses.push_back({index, Stamp{index}, mapped});
      if (index == kPerPass - 1) leave_and_return();
    }
  }
  PointCloudPtr cloud(KeyFrameIndex index) override {
    const auto found = clouds_.find(index);
    return found == clouds_.end() ? nullptr : found->second;
  }
  KeyFramePoses poses;

 private:
  void leave_and_return() {
    Pose pose;
    pose.translation.y() = 500.0;
    poses.poses.push_back({999, 0, pose});
  }

  static Eigen::Vector3d surface_point(std::mt19937& random) {
    std::uniform_real_distribution<double> x(-10.0, 40.0);
    std::uniform_real_distribution<double> z(-1.8, 5.0);
    std::uniform_real_distribution<double> y(-8.0, 8.0);
    std::uniform_real_distribution<double> depth(8.0, 12.0);
    switch (random() % 5) {
      case 0:
        return {x(random), 8.3, z(random)};
      case 1:
        return {x(random), -8.2, z(random)};
      case 2:
        return {10.0 * static_cast<double>(random() % 4) + 0.3, depth(random), z(random)};
      default:
        return {x(random), y(random), -1.8};
    }
  }

  static PointCloudPtr scan(const Pose& T_map_base, std::mt19937& random) {
    std::normal_distribution<double> noise(0.0, kNoise);
    auto cloud = std::make_shared<PointCloud>();
    for (int i = 0; i < 25'000; ++i) {
      const Eigen::Vector3d p = T_map_base.inverse() * surface_point(random);
      const Eigen::Vector3f measured = (p + noise(random) * p.normalized()).cast<float>();
      cloud->points.push_back({measured.x(), measured.y(), measured.z(), 0.0F});
    }
    return cloud;
  }

  std::map<KeyFrameIndex, PointCloudPtr> clouds_;
};

Pose displacement_by(double x, double y, double z, double yaw = 0.0) {
  return {exp_so3({0.0, 0.0, yaw}), {x, y, z}};
}

double misalignment_error(const Pose& displacement, const Eigen::Vector3d& expected) {
  TwoPasses passes(displacement);
  const auto misalignments = pass_misalignments(passes.poses, passes, {});
  EXPECT_GE(misalignments.size(), 2U);
  double worst = 0.0;
  for (const PassMisalignment& misalignment : misalignments) {
    worst = std::max(
        worst,
        (Eigen::Vector3d(misalignment.forward, misalignment.left, misalignment.up) - expected)
            .norm());
  }
  return worst;
}

// The size of a known displacement is found to 1 cm.
TEST(PassMisalignments, FindDisplacementToACentimetre) {
  EXPECT_LT(misalignment_error(displacement_by(0.0, 0.0, 0.0), {0.0, 0.0, 0.0}), 0.01);
  EXPECT_LT(misalignment_error(displacement_by(0.0, 0.05, 0.0), {0.0, 0.05, 0.0}), 0.01);
  EXPECT_LT(misalignment_error(displacement_by(0.0, 0.0, 0.05), {0.0, 0.0, 0.05}), 0.01);
  EXPECT_LT(misalignment_error(displacement_by(0.0, -0.3, 0.2), {0.0, -0.3, 0.2}), 0.01);
}

TEST(PassMisalignments, FindRotation) {
  TwoPasses passes(displacement_by(0.0, 0.0, 0.0, 0.2 * kRadPerDeg));
  const auto misalignments = pass_misalignments(passes.poses, passes, {});
  ASSERT_FALSE(misalignments.empty());
  for (const PassMisalignment& misalignment : misalignments)
    EXPECT_NEAR(misalignment.yaw * kDegPerRad, 0.2, 0.05);
}

TEST(PassMisalignments, DriveWithoutRevisitsHasNone) {
  TwoPasses passes(displacement_by(0.0, 100.0, 0.0));
  EXPECT_TRUE(pass_misalignments(passes.poses, passes, {}).empty());
}

// Thickness as a ratio to that of range noise alone.
TEST(LocalThickness, PerfectMapHasThicknessOfNoise) {
  TwoPasses passes(displacement_by(0.0, 0.0, 0.0));
  const LocalThickness thickness = local_thickness(passes.poses, passes, {});
  EXPECT_GT(thickness.ground.cells, 500U);
  EXPECT_GT(thickness.walls.cells, 500U);
  EXPECT_NEAR(thickness.ground.median_ratio, 1.0, 0.1);
  EXPECT_NEAR(thickness.walls.median_ratio, 1.0, 0.1);
}

TEST(LocalThickness, GrowsWithDistanceOfPasses) {
  TwoPasses good(displacement_by(0.0, 0.0, 0.0));
  TwoPasses displaced(displacement_by(0.0, 0.0, 0.1));
  const double before = local_thickness(good.poses, good, {}).ground.median;
  const double after = local_thickness(displaced.poses, displaced, {}).ground.median;
  EXPECT_GT(after, 2.0 * before);
}

// An odometry that begins at UTM coordinates.
TEST(LocalThickness, IsTheSameFarFromTheOrigin) {
  TwoPasses passes(displacement_by(0.0, 0.0, 0.0));
  const LocalThickness near = local_thickness(passes.poses, passes, {});
  for (KeyFramePose& pose : passes.poses.poses) {
    pose.T_map_base.translation += Eigen::Vector3d(400'000.0, 5'400'000.0, 0.0);
  }
  const LocalThickness far = local_thickness(passes.poses, passes, {});
  EXPECT_NEAR(far.ground.median, near.ground.median, 1e-4);
  EXPECT_NEAR(far.walls.median, near.walls.median, 1e-4);
  EXPECT_NEAR(far.planar_fraction, near.planar_fraction, 0.01);
}

TEST(MapEntropy, GrowsWithDistanceOfPasses) {
  TwoPasses good(displacement_by(0.0, 0.0, 0.0));
  TwoPasses displaced(displacement_by(0.0, 0.0, 0.1));
  const MapEntropy before = mean_map_entropy(good.poses, good);
  const MapEntropy after = mean_map_entropy(displaced.poses, displaced);
  EXPECT_GT(before.points, 1000U);
  EXPECT_GT(before.neighbours, 5.0);
  EXPECT_GT(after.mean, before.mean + 0.3);
}

TEST(PassPoints, AreInTheAxesOfTheVehicle) {
  TwoPasses passes(displacement_by(0.0, 0.0, 0.0));
  const auto misalignments = pass_misalignments(passes.poses, passes, {});
  ASSERT_FALSE(misalignments.empty());
  const PassPoints points = pass_points(passes.poses, passes, {}, misalignments.front());
  ASSERT_GT(points.later.size(), 1000U);
  ASSERT_GT(points.earlier.size(), 1000U);
  double lowest = 0.0;
  for (const auto& point : points.later) lowest = std::min<double>(lowest, point.z());
  EXPECT_NEAR(lowest, -1.8, 0.1);
}

}  // namespace
}  // namespace lidar_mapping::map_quality
