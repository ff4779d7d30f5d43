// SPDX-License-Identifier: BSD-3-Clause
#include "method_test.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

class Methods : public MethodTest {};

TEST_P(Methods, FindTheTruthFromADisturbedStart) {
  const Scene scene = make_scene(0.02);
  const Pose guess = scene.T_target_source * pose_of(0.4, -0.3, 0.1, 0.01, 0.02, -0.05);
  const RegistrationResult result = aligned(scene.target, scene.source, guess, config());
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(test::near(result.T_target_source, scene.T_target_source, 0.04, 0.004));
  EXPECT_GT(result.overlap, 0.95);
  EXPECT_GT(result.inlier_fraction, 0.9);
}

TEST_P(Methods, FindTheInverseWithTheCloudsExchanged) {
  const Scene scene = make_scene(0.02);
  const RegistrationResult result =
      aligned(scene.source, scene.target,
              scene.T_target_source.inverse() * pose_of(0.3, 0.2, 0, 0, 0, 0.04), config());
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(test::near(result.T_target_source, scene.T_target_source.inverse(), 0.06, 0.006));
}

TEST_P(Methods, AreRobustAgainstNoise) {
  const Scene scene = make_scene(0.1);
  const RegistrationResult result =
      aligned(scene.target, scene.source, scene.T_target_source * pose_of(-0.3, 0.3, 0, 0, 0, 0.04),
              config());
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(test::near(result.T_target_source, scene.T_target_source, 0.1, 0.008));
}

// The method's library may call it converged; this package does not.
TEST_P(Methods, ReportThatIterationsRanOut) {
  const Scene scene = make_scene(0.02);
  RegistrationConfig hasty = config();
  hasty.max_iterations = 1;
  const RegistrationResult result = aligned(
      scene.target, scene.source, scene.T_target_source * pose_of(1.5, 1, 0, 0, 0, 0.1), hasty);
  EXPECT_FALSE(result.converged);
}

// A scan of another place fits nowhere, and the figures say so.
TEST_P(Methods, ShowThatAForeignCloudDoesNotFit) {
  const Scene scene = make_scene(0.02);
  PointCloud foreign;
  for (const Point& p : scene.source.points) {
    foreign.points.push_back({p.z * 3.0F, p.x * 0.4F, p.y * 0.6F, 0.0F});
  }
  const RegistrationResult result = aligned(scene.target, foreign, scene.T_target_source, config());
  EXPECT_LT(result.inlier_fraction, 0.5);
}

TEST_P(Methods, RefuseEmptyAndUselessClouds) {
  const Scene scene = make_scene(0.02);
  const PointCloud nothing;
  PointCloud broken;
  broken.points.assign(100, {NAN, NAN, NAN, 0.0F});
  for (const PointCloud& useless : {nothing, broken}) {
    for (const auto& result : {aligned(useless, scene.source, scene.T_target_source, config()),
                               aligned(scene.target, useless, scene.T_target_source, config())}) {
      EXPECT_FALSE(result.converged);
      EXPECT_EQ(result.overlap, 0.0);
      EXPECT_TRUE(
          test::near(result.T_target_source.translation, scene.T_target_source.translation, 1e-12));
    }
  }
}

TEST_P(Methods, GiveTheSameBitsEachTime) {
  const Scene scene = make_scene(0.02);
  const Pose guess = scene.T_target_source * pose_of(0.4, -0.3, 0.1, 0.01, 0.02, -0.05);
  const auto registration = make_registration(config());
  registration->set_target(scene.target);
  const RegistrationResult first = registration->align(scene.source, guess);
  registration->align(scene.source, scene.T_target_source);
  const RegistrationResult again = registration->align(scene.source, guess);
  EXPECT_EQ(first.T_target_source.matrix(), again.T_target_source.matrix());
  EXPECT_EQ(first.hessian, again.hessian);
}

TEST_P(Methods, GiveTheSameBitsForAnyNumberOfThreads) {
  const Scene scene = make_scene(0.02);
  const Pose guess = scene.T_target_source * pose_of(0.4, -0.3, 0.1, 0.01, 0.02, -0.05);
  RegistrationConfig parallel = config();
  const RegistrationResult one = aligned(scene.target, scene.source, guess, parallel);
  for (const int threads : {2, 4}) {
    parallel.num_threads = threads;
    const RegistrationResult more = aligned(scene.target, scene.source, guess, parallel);
    EXPECT_EQ(one.T_target_source.matrix(), more.T_target_source.matrix());
    EXPECT_EQ(one.hessian, more.hessian);
  }
}

TEST_P(Methods, KeepTheirPrecisionFarFromTheOrigin) {
  // As in a submap 300 m away from the frame's origin; floats resolve 0.03 mm there.
  const Scene scene = make_scene(0.02);
  const Pose T_far_target = pose_of(300.0, -200.0, 10.0, 0.0, 0.0, 0.0);
  const RegistrationResult near = aligned(
      scene.target, scene.source, scene.T_target_source * pose_of(0.2, 0, 0, 0, 0, 0), config());
  const RegistrationResult far =
      aligned(transformed(scene.target, T_far_target), scene.source,
              T_far_target * scene.T_target_source * pose_of(0.2, 0, 0, 0, 0, 0), config());
  const Pose found = T_far_target.inverse() * far.T_target_source;
  EXPECT_TRUE(test::near(found, near.T_target_source, 0.03, 0.003));
}

INSTANTIATE_TEST_SUITE_P(All, Methods, testing::ValuesIn(kAllMethods), method_name);

}  // namespace
}  // namespace lidar_mapping::registration
