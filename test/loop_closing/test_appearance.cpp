// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include "matching/surface.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"
#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

Appearance appearance_at(const ToyWorld& world, const Pose& pose) {
  return appearance_of(positions(world.scan(pose, 7)));
}

double modulo_pi(double angle) { return std::abs(std::remainder(angle, kPi)); }

// The heading comes from the descriptor, the position from the correlation.
TEST(Appearance, GivesHeadingAndPositionOfARevisit) {
  const ToyWorld world = make_town(150.0, 100.0, 4);
  const Pose older = planar(10.0, 0.0, 0.0);
  const Appearance a = appearance_at(world, older);
  for (const double heading : {0.0, 0.4, 1.6, kPi, -2.0}) {
    const Pose newer = planar(13.0, 3.5, heading);
    const Appearance b = appearance_at(world, newer);
    const double turn = a.descriptor.compare(b.descriptor).yaw;
    EXPECT_LT(modulo_pi(turn - heading), 0.05) << heading;
    const ViewCorrelator correlator(a.view);
    const ViewMatch right = correlator.match(b.view.cells(), heading);
    const ViewMatch wrong = correlator.match(b.view.cells(), heading + kPi);
    EXPECT_GT(right.score, wrong.score) << heading;
    EXPECT_TRUE(near(right.translation, Eigen::Vector2d(3.0, 3.5), 1.5)) << heading;
  }
}

// More cells than a byte can count.
TEST(Appearance, AViewMatchesItselfBest) {
  std::vector<Eigen::Vector3f> points;
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> coordinate(-40.0F, 40.0F);
  for (int i = 0; i < 900; ++i) {
    points.emplace_back(coordinate(generator), coordinate(generator), 0.0F);
  }
  const BirdsEyeView view(points, std::vector<bool>(points.size(), true));
  const ViewMatch match = ViewCorrelator(view).match(view.cells(), 0.0);
  EXPECT_EQ(match.translation, Eigen::Vector2d::Zero());
  EXPECT_NEAR(match.score, 1.0, 1e-9);
}

TEST(Appearance, KeyDoesNotChangeWithTheHeading) {
  const ToyWorld world = make_town(150.0, 100.0, 4);
  const auto key = appearance_at(world, planar(0.0, 0.0, 0.0)).descriptor.key();
  const auto turned = appearance_at(world, planar(1.0, 0.5, 2.2)).descriptor.key();
  const auto elsewhere = appearance_at(world, planar(60.0, 0.0, 0.0)).descriptor.key();
  EXPECT_LT((key - turned).norm(), 0.7F * (key - elsewhere).norm());
}

TEST(AppearanceIndex, FindsARevisitedLocation) {
  const ToyWorld world = make_town(150.0, 100.0, 5);
  AppearanceIndex index(std::filesystem::temp_directory_path());
  for (const Pose& pose : along({{-100, 0}, {100, 0}}, 5.0)) {
    index.append(appearance_at(world, pose));
  }
  const Appearance revisit = appearance_at(world, planar(21.0, 3.5, kPi));
  const auto of_another_drive = index.similar_to(revisit, 25, 10);
  EXPECT_EQ(index.similar_to(revisit, 5, 3).size(), 3U);
  index.append(revisit);
  const auto similar = index.similar_to_newest([](std::size_t) { return true; });
  ASSERT_FALSE(similar.empty());
  EXPECT_EQ(of_another_drive, similar);
  EXPECT_NEAR(static_cast<double>(similar.front()), 24.0, 1.0);
  EXPECT_LE(similar.size(), 10U);
}

TEST(AppearanceIndex, SkipsInadmissibleNodesAndNodesWithoutACloud) {
  const ToyWorld world = make_town(100.0, 100.0, 5);
  AppearanceIndex index(std::filesystem::temp_directory_path());
  index.append(appearance_at(world, planar(0.0, 0.0, 0.0)));
  index.append(std::nullopt);
  EXPECT_TRUE(index.similar_to_newest([](std::size_t) { return true; }).empty());
  index.append(appearance_at(world, planar(0.0, 0.0, 0.0)));
  EXPECT_TRUE(index.similar_to_newest([](std::size_t) { return false; }).empty());
  EXPECT_EQ(index.similar_to_newest([](std::size_t) { return true; }).size(), 1U);
}

TEST(AppearanceIndex, ReturnsTheStoredAppearances) {
  const ToyWorld world = make_town(100.0, 100.0, 5);
  AppearanceIndex index(std::filesystem::temp_directory_path());
  index.append(std::nullopt);
  const Appearance first = appearance_at(world, planar(0.0, 0.0, 0.0));
  index.append(first);
  index.append(appearance_at(world, planar(20.0, 0.0, 1.0)));
  EXPECT_FALSE(index[0].has_value());
  ASSERT_TRUE(index[1].has_value());
  EXPECT_EQ(index[1]->view.cells(), first.view.cells());
  EXPECT_EQ(index[1]->descriptor.key(), first.descriptor.key());
}

// Nodes are numbered as those of the trajectory, whatever happens to the disk.
TEST(AppearanceIndex, CountsANodeWhoseAppearanceCannotBeStored) {
  const lidar_mapping::test::TemporaryFolder folder;
  const std::filesystem::path no_folder = folder.path() / "file";
  std::ofstream(no_folder) << "in the way";
  AppearanceIndex index(no_folder);
  const Appearance appearance = appearance_at(make_town(100.0, 100.0, 5), planar(0.0, 0.0, 0.0));
  EXPECT_THROW(index.append(appearance), FileError);
  EXPECT_FALSE(index[0].has_value());
  std::filesystem::remove(no_folder);
  index.append(appearance);
  ASSERT_TRUE(index[1].has_value());
  EXPECT_EQ(index[1]->view.cells(), appearance.view.cells());
}

std::vector<Appearance> appearances_along_path(const ToyWorld& world) {
  std::vector<Appearance> appearances;
  for (const Pose& pose : along({{-100, 0}, {100, 0}}, 2.0)) {
    appearances.push_back(appearance_at(world, pose));
  }
  return appearances;
}

TEST(CoarseKey, BoundsTheDistanceOfTheKeys) {
  const std::vector<Appearance> appearances = appearances_along_path(make_town(150.0, 100.0, 5));
  for (std::size_t i = 0; i + 1 < appearances.size(); ++i) {
    const auto a = appearances[i].descriptor.key();
    const auto b = appearances[appearances.size() - 1 - i].descriptor.key();
    const CoarseKey::Bounds bounds = CoarseKey(a).distance_to(CoarseKey(b));
    EXPECT_LE(bounds.lower, (a - b).norm()) << i;
    EXPECT_GE(bounds.upper, (a - b).norm()) << i;
    EXPECT_LT(bounds.upper - bounds.lower, 0.25F) << i;
  }
  SpectrumDescriptor::Key beyond = SpectrumDescriptor::Key::Constant(3.0F);
  const CoarseKey::Bounds bounds = CoarseKey(beyond).distance_to(CoarseKey(0.5F * beyond));
  EXPECT_LE(bounds.lower, 0.5F * beyond.norm());
  EXPECT_GE(bounds.upper, 0.5F * beyond.norm());
}

/// The 25 nearest keys, and the 10 most similar of these.
std::vector<std::size_t> most_similar_by_full_search(const std::vector<Appearance>& appearances) {
  const SpectrumDescriptor& newest = appearances.back().descriptor;
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i + 1 < appearances.size(); ++i) {
    ranked.emplace_back((appearances[i].descriptor.key() - newest.key()).squaredNorm(), i);
  }
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(25);
  for (auto& [cost, i] : ranked) cost = -appearances[i].descriptor.compare(newest).similarity;
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i < 10; ++i) nodes.push_back(ranked[i].second);
  return nodes;
}

TEST(AppearanceIndex, AgreesWithASearchAmongTheFullKeys) {
  const ToyWorld world = make_town(150.0, 100.0, 5);
  std::vector<Appearance> appearances = appearances_along_path(world);
  for (const double x : {-60.0, 13.0, 85.0}) {
    appearances.push_back(appearance_at(world, planar(x, 2.0, 2.0)));
    AppearanceIndex index(std::filesystem::temp_directory_path());
    for (const Appearance& appearance : appearances) index.append(appearance);
    EXPECT_EQ(index.similar_to_newest([](std::size_t) { return true; }),
              most_similar_by_full_search(appearances));
    appearances.pop_back();
  }
}

// At a new location the keys hardly depend on the similarity of the views, so that each of the
// nearest keys counts.
TEST(AppearanceIndex, AgreesWithTheFullSearchAtANewLocation) {
  std::vector<Appearance> appearances = appearances_along_path(make_town(150.0, 100.0, 5));
  const ToyWorld elsewhere = make_town(150.0, 100.0, 6);
  for (const double x : {-60.0, 13.0, 85.0}) {
    appearances.push_back(appearance_at(elsewhere, planar(x, 2.0, 2.0)));
    AppearanceIndex index(std::filesystem::temp_directory_path());
    for (const Appearance& appearance : appearances) index.append(appearance);
    EXPECT_EQ(index.similar_to_newest([](std::size_t) { return true; }),
              most_similar_by_full_search(appearances));
    appearances.pop_back();
  }
}

TEST(BirdsEyeView, EmptyViewsMatchNothing) {
  const ViewCorrelator correlator{BirdsEyeView()};
  EXPECT_EQ(correlator.match({{0.5F, 0.5F}}, 0.0).score, 0.0);
  EXPECT_EQ(SpectrumDescriptor().compare(SpectrumDescriptor()).similarity, 0.0);
}

TEST(Appearance, HasALimitedSize) {
  EXPECT_LT(sizeof(Appearance), 8192U);
  EXPECT_LT(sizeof(std::optional<CoarseKey>), 400U);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
