// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "method_test.hpp"

namespace lidar_mapping::registration {
namespace {

class Judgement : public MethodTest {};

TEST_P(Judgement, CountsOnlyWhatHasAPartner) {
  Scene scene = make_scene(0.02);
  const std::size_t inside = scene.source.size();
  for (std::size_t i = 0; i < inside; ++i) {
    scene.source.points.push_back({0.01F * static_cast<float>(i), 0.0F, 60.0F, 0.0F});
  }
  const RegistrationResult result =
      aligned(scene.target, scene.source, scene.T_target_source, config());
  EXPECT_NEAR(result.overlap, 0.5, 0.02);
  EXPECT_LT(result.fitness, 0.05);  // of the pairs: the far half is not in it
}

TEST_P(Judgement, IsFiniteWhereNothingHasAPartner) {
  Scene scene = make_scene(0.02);
  for (Point& p : scene.source.points) p.x += 500.0F;
  const RegistrationResult result = aligned(scene.target, scene.source, Pose::Identity(), config());
  EXPECT_EQ(result.overlap, 0.0);
  EXPECT_EQ(result.inlier_fraction, 0.0);
  EXPECT_TRUE(std::isfinite(result.fitness));
}

TEST_P(Judgement, FitnessIsTheMeanSquaredDistanceOfPairs) {
  // Three walls, and points 0.1 m before and behind them in turn: no pose brings them nearer.
  PointCloud walls, beside;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      const float u = 0.25F * static_cast<float>(i) + 0.7F;
      const float v = 0.25F * static_cast<float>(j) + 0.7F;
      const float d = (i + j) % 2 == 0 ? 0.1F : -0.1F;
      const Eigen::Vector3f places[] = {{u, v, 0.5F}, {u, 0.5F, v}, {0.5F, u, v}};
      for (int wall = 0; wall < 3; ++wall) {
        const Eigen::Vector3f& p = places[wall];
        const Eigen::Vector3f q = p + d * Eigen::Vector3f::Unit(2 - wall);
        walls.points.push_back({p.x(), p.y(), p.z(), 0.0F});
        beside.points.push_back({q.x(), q.y(), q.z(), 0.0F});
      }
    }
  }
  const RegistrationResult result = aligned(walls, beside, Pose::Identity(), config());
  EXPECT_NEAR(result.fitness, 0.01, 0.001);
  EXPECT_NEAR(result.overlap, 1.0, 0.001);
}

// The covariance that follows from the Hessian is of the size of the true errors.
TEST_P(Judgement, InverseHessianHasTheSizeOfTheErrors) {
  constexpr int kRuns = 12;
  double normalised = 0.0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const Scene scene = make_scene(0.05, 1000 + seed);
    const RegistrationResult result =
        aligned(scene.target, scene.source, scene.T_target_source, config());
    const Vector6d error = difference(result.T_target_source, scene.T_target_source);
    normalised += error.dot(result.hessian * error) / (6.0 * kRuns);
  }
  RecordProperty("normalised_error_squared", std::to_string(normalised));
  EXPECT_GT(normalised, 0.1);
  EXPECT_LT(normalised, 2.0);
}

TEST_P(Judgement, HessianShowsWhatAPlaneDoesNotHold) {
  PointCloud plane;
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 60; ++j) {
      plane.points.push_back(
          {static_cast<float>(0.2 * i), static_cast<float>(0.2 * j), 0.0F, 0.0F});
    }
  }
  const RegistrationResult result = aligned(plane, plane, Pose::Identity(), config());
  EXPECT_GT(result.hessian(2, 2), 1e4);
  EXPECT_LT(result.hessian(0, 0), 1e-3 * result.hessian(2, 2));
  EXPECT_LT(result.hessian(1, 1), 1e-3 * result.hessian(2, 2));
  EXPECT_LT(result.hessian(5, 5), 1e-3 * result.hessian(4, 4));
}

INSTANTIATE_TEST_SUITE_P(All, Judgement, testing::ValuesIn(kAllMethods), method_name);

}  // namespace
}  // namespace lidar_mapping::registration
