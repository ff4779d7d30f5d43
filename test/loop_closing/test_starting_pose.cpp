// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "candidates/starting_pose.hpp"
#include "drive.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

/// Posts in the middle of cells of 1 m within 35 m, in base_link of the older key frame.
std::vector<Eigen::Vector2d> posts(int count) {
  std::mt19937 engine(8);
  std::uniform_int_distribution<int> cell(-25, 24);
  std::vector<Eigen::Vector2d> result;
  for (int i = 0; i < count; ++i) {
    const double x = cell(engine) + 0.5;
    result.emplace_back(x, cell(engine) + 0.5);
  }
  return result;
}

/// The appearance of posts of 2 m on level ground, as seen from a pose.
Appearance seen_from(const Pose& T_older_here, const std::vector<Eigen::Vector2d>& posts_older) {
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector2d& post : posts_older) {
    for (const double height : {0.0, 2.0}) {
      const Eigen::Vector3d p_older(post.x(), post.y(), height);
      points.push_back((T_older_here.inverse() * p_older).cast<float>());
    }
  }
  return appearance_of(points);
}

/// Two key frames that see the same posts; the newer one is turned by a quarter, so that its cells
/// are those of the older one.
class StartingPoseByViews : public testing::Test {
 protected:
  StartingPose start(const Prior& prior, int count = 150) const {
    const Appearance older = seen_from(Pose(), posts(count));
    const Appearance newer = seen_from(truth_, posts(count));
    return starting_pose_by_views(prior, older, newer, newer.view.cells());
  }
  /// An estimate with these standard deviations, 5 m and 0.2 rad beside the truth and tilted.
  Prior wrong_prior(double sigma_horizontal, double sigma_rotation) const {
    Prior prior;
    prior.anchored = true;
    prior.T_from_to = planar(8.0, 2.0, kPi / 2.0 + 0.2, 1.5);
    prior.T_from_to.rotation = prior.T_from_to.rotation * exp_so3({0.05, 0.0, 0.0});
    prior.sigma_horizontal = sigma_horizontal;
    prior.sigma_rotation = sigma_rotation;
    return prior;
  }
  /// That estimate on the ground plane.
  const Pose level_prior_ = planar(8.0, 2.0, kPi / 2.0 + 0.2);
  const Pose truth_ = planar(3.0, 2.0, kPi / 2.0);
};

TEST_F(StartingPoseByViews, IsTheLevelEstimateWithoutViews) {
  const Prior prior = wrong_prior(10.0, 1.0);
  const Appearance view = seen_from(Pose(), posts(150));
  const std::vector<Eigen::Vector2f> cells = view.view.cells();
  const StartingPose without[] = {starting_pose_by_views(prior, {}, view, cells),
                                  starting_pose_by_views(prior, view, {}, cells),
                                  starting_pose_by_views(prior, {}, {}, {})};
  for (const StartingPose& level : without) {
    EXPECT_TRUE(near(level.T_from_to, level_prior_, 0.01));
    EXPECT_EQ(level.T_from_to.translation.z(), 0.0);
    EXPECT_EQ(level.score, 0.0);
  }
}

TEST_F(StartingPoseByViews, IsTheLevelEstimateIfLittleIsSeen) {
  const StartingPose few = start(wrong_prior(10.0, 1.0), 25);
  EXPECT_TRUE(near(few.T_from_to, level_prior_, 0.01));
  EXPECT_EQ(few.score, 0.0);
}

TEST_F(StartingPoseByViews, IsWhereTheViewsAgreeIfNothingElseIsKnown) {
  const StartingPose found = start(Prior());
  EXPECT_TRUE(near(found.T_from_to, truth_, 0.5, 0.06));
  EXPECT_GT(found.score, 0.9);
}

TEST_F(StartingPoseByViews, IsWhereTheViewsAgreeIfTheEstimateIsLessCertain) {
  for (const double sigma_rotation : {0.1, 1.0}) {
    const StartingPose found = start(wrong_prior(5.0, sigma_rotation));
    EXPECT_TRUE(near(found.T_from_to, truth_, 0.5, 0.06)) << sigma_rotation;
    EXPECT_GT(found.score, 0.9);
  }
}

TEST_F(StartingPoseByViews, IsTheEstimateIfThatIsMoreCertainThanTheViews) {
  const StartingPose certain = start(wrong_prior(0.5, 0.1));
  EXPECT_TRUE(near(certain.T_from_to, level_prior_, 0.01));
  EXPECT_GT(certain.score, 0.9) << "which says all the same that the views agree";
  Prior unconnected = wrong_prior(0.5, 0.1);
  unconnected.anchored = false;
  EXPECT_TRUE(near(start(unconnected).T_from_to, truth_, 0.5, 0.06)) << "it means nothing";
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
