#include <gtest/gtest.h>

#include "lidar_mapping/loop_closing/appearance_index.hpp"
#include "lidar_mapping/loop_closing/surface.hpp"

#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

Appearance seen_from(const ToyWorld& world, const Pose& pose) {
  const auto points = positions(world.scan(pose, 7));
  Appearance appearance;
  appearance.view = BirdsEye(points, above_ground(points));
  appearance.descriptor = SpectrumDescriptor(appearance.view.cells());
  return appearance;
}

double modulo_pi(double angle) { return std::abs(std::remainder(angle, kPi)); }

// F74: the heading comes from the descriptor, the position from the correlation.
TEST(Appearance, GivesHeadingAndPositionOfARevisit) {
  const ToyWorld world = make_town(150.0, 100.0, 4);
  const Pose older = planar(10.0, 0.0, 0.0);
  const Appearance a = seen_from(world, older);
  for (const double heading : {0.0, 0.4, 1.6, kPi, -2.0}) {
    const Pose newer = planar(13.0, 3.5, heading);
    const Appearance b = seen_from(world, newer);
    const double turn = a.descriptor.compare(b.descriptor).yaw;
    EXPECT_LT(modulo_pi(turn - heading), 0.05) << heading;
    const ViewCorrelator correlator(a.view);
    const ViewMatch right = correlator.match(b.view.cells(), heading);
    const ViewMatch wrong = correlator.match(b.view.cells(), heading + kPi);
    EXPECT_GT(right.score, wrong.score) << heading;
    EXPECT_LT((right.translation - Eigen::Vector2d(3.0, 3.5)).norm(), 1.5) << heading;
  }
}

TEST(Appearance, KeyDoesNotChangeWithTheHeading) {
  const ToyWorld world = make_town(150.0, 100.0, 4);
  const auto key = seen_from(world, planar(0.0, 0.0, 0.0)).descriptor.key();
  const auto turned = seen_from(world, planar(1.0, 0.5, 2.2)).descriptor.key();
  const auto elsewhere = seen_from(world, planar(60.0, 0.0, 0.0)).descriptor.key();
  EXPECT_LT((key - turned).norm(), 0.7F * (key - elsewhere).norm());
}

TEST(AppearanceIndex, FindsThePlaceAgainAmongAll) {
  const ToyWorld world = make_town(150.0, 100.0, 5);
  AppearanceIndex index;
  for (const Pose& pose : along({{-100, 0}, {100, 0}}, 5.0)) {
    index.append(seen_from(world, pose));
  }
  index.append(seen_from(world, planar(21.0, 3.5, kPi)));
  const auto similar = index.similar_to_newest([](std::size_t) { return true; });
  ASSERT_FALSE(similar.empty());
  EXPECT_NEAR(static_cast<double>(similar.front()), 24.0, 1.0);
  EXPECT_LE(similar.size(), 10U);
}

TEST(AppearanceIndex, SkipsWhatIsNotAdmittedAndWhatHasNoCloud) {
  const ToyWorld world = make_town(100.0, 100.0, 5);
  AppearanceIndex index;
  index.append(seen_from(world, planar(0.0, 0.0, 0.0)));
  index.append(std::nullopt);
  EXPECT_TRUE(index.similar_to_newest([](std::size_t) { return true; }).empty());
  index.append(seen_from(world, planar(0.0, 0.0, 0.0)));
  EXPECT_TRUE(index.similar_to_newest([](std::size_t) { return false; }).empty());
  EXPECT_EQ(index.similar_to_newest([](std::size_t) { return true; }).size(), 1U);
}

TEST(BirdsEye, EmptyViewsMatchNothing) {
  const ViewCorrelator correlator{BirdsEye()};
  EXPECT_EQ(correlator.match({{0.5F, 0.5F}}, 0.0).score, 0.0);
  EXPECT_EQ(SpectrumDescriptor().compare(SpectrumDescriptor()).similarity, 0.0);
}

TEST(Appearance, TakesABoundedFewKilobytes) { EXPECT_LT(sizeof(Appearance), 8192U); }

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
