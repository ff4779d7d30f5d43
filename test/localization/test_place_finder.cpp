// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "map_parts.hpp"
#include "near.hpp"
#include "place_finder.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;
using Confirmation = PlaceFinder::Confirmation;

/// A vehicle that stands still in a street of the map.
class PlaceFinderTest : public testing::Test {
 protected:
  static Pose truth() { return planar(-20.0, 1.5, 2.8); }

  LocalizerInput seen(std::uint32_t seed, const ToyWorld& world = town()) const {
    LocalizerInput input;
    input.scan.cloud = world.scan(truth(), seed);
    input.p_base_lidar = ToyWorld::sensor();
    return input;
  }
  std::optional<Hypothesis> search(const LocalizerInput& input) {
    const ScanPoints points = sampler_.sample(input.scan.cloud, input.p_base_lidar);
    return finder_.search(input, points, matcher_, 0.0);
  }
  const Hypothesis* best() const { return finder_.hypotheses().best(); }

  ScanPointSampler sampler_;
  MapMatcher matcher_;
  PlaceFinder finder_{town_map().parts()};
};

TEST_F(PlaceFinderTest, ConfirmsAPlaceAfterAMetreOrFiveScans) {
  const Pose guess = planar(-19.0, 1.0, 2.75);
  for (int scan = 1; scan < 5; ++scan) {
    EXPECT_EQ(finder_.confirm(seen(9), guess, 0.1).outcome, Confirmation::kNotDue) << scan;
  }
  const PlaceFinder::Confirmed fifth = finder_.confirm(seen(9), guess, 0.1);
  ASSERT_EQ(fifth.outcome, Confirmation::kAccepted);
  EXPECT_TRUE(near(fifth.verified.T_map_base, truth(), 0.15, 0.01));
  EXPECT_EQ(finder_.confirm(seen(9), guess, 0.9).outcome, Confirmation::kNotDue);
  EXPECT_EQ(finder_.confirm(seen(9), guess, 0.2).outcome, Confirmation::kAccepted);
}

TEST_F(PlaceFinderTest, RefusesAnotherStreet) {
  EXPECT_EQ(finder_.confirm(seen(9), planar(48.0, 60.0, 2.8), 1.0).outcome, Confirmation::kRefused);
}

// Two candidates are verified with a scan: the claimed pose itself, and where the view from above
// agrees near it.
TEST_F(PlaceFinderTest, LooksAtAClaimedPoseFirst) {
  finder_.claim(truth());
  EXPECT_FALSE(search(seen(9))) << "one search is not enough";
  ASSERT_EQ(finder_.hypotheses().size(), 1U);
  EXPECT_EQ(best()->verifications(), 1);
  EXPECT_TRUE(near(best()->estimate().T_map_base, truth(), 0.15, 0.01));
  EXPECT_EQ(finder_.reason(), "one place is possible, but it is not confirmed yet");
}

TEST_F(PlaceFinderTest, CarriesAClaimAndPlacesAlongByOdometry) {
  const Pose motion = planar(30.0, 0.0, 0.2);
  finder_.claim(truth() * motion.inverse());
  finder_.move(motion, diagonal_covariance(0.01, 0.001));
  search(seen(9));
  ASSERT_EQ(finder_.hypotheses().size(), 1U);
  const Pose found = best()->estimate().T_map_base;
  EXPECT_TRUE(near(found, truth(), 0.15, 0.01));
  finder_.move(motion, diagonal_covariance(0.01, 0.001));
  EXPECT_TRUE(near(best()->estimate().T_map_base, found * motion, 1e-9));
}

// At rest the second search begins five scans after the first one.
TEST_F(PlaceFinderTest, IsCertainInTheSecondSearchAtTheEarliest) {
  finder_.claim(truth());
  std::optional<Hypothesis> found;
  std::uint32_t scans = 0;
  while (!found && scans < 30) found = search(seen(8 + ++scans));
  ASSERT_TRUE(found) << finder_.reason();
  EXPECT_GE(scans, 6U);
  EXPECT_GE(found->verifications(), 2);
  EXPECT_EQ(found->evidence(), Evidence::kAgrees);
  EXPECT_GE(finder_.hypotheses().probability(), 0.99);
  EXPECT_TRUE(near(found->estimate().T_map_base, truth(), 0.15, 0.01));
}

// The first search looks at more than two candidates with the first scan and goes on with the
// next; scans a second apart leave time for all.
TEST_F(PlaceFinderTest, VerifiesMoreCandidatesIfScansAreFarApart) {
  const auto scans_of_first_search = [&](double interval) {
    finder_.restart();
    LocalizerInput input = seen(9);
    int scans = 0;
    while (finder_.searches() == 0 && scans < 20) {
      input.scan.stamp = from_seconds(1.0 + interval * scans++);
      search(input);
    }
    return scans;
  };
  EXPECT_GE(scans_of_first_search(0.1), 3);
  EXPECT_EQ(scans_of_first_search(1.0), 2);
}

TEST_F(PlaceFinderTest, FindsNoPlaceForBareGround) {
  for (int scan = 1; scan <= 6; ++scan) EXPECT_FALSE(search(seen(9, ToyWorld())));
  EXPECT_EQ(best(), nullptr);
  EXPECT_EQ(finder_.reason(), "no place in the map matches the scan");
}

TEST_F(PlaceFinderTest, BeginsAnewWithoutAnyKnowledge) {
  finder_.claim(truth());
  search(seen(9));
  ASSERT_EQ(finder_.hypotheses().size(), 1U);
  EXPECT_EQ(finder_.confirm(seen(9), truth(), 0.5).outcome, Confirmation::kNotDue);
  finder_.restart();
  EXPECT_EQ(finder_.hypotheses().size(), 0U);
  EXPECT_EQ(finder_.confirm(seen(9), truth(), 0.9).outcome, Confirmation::kNotDue)
      << "the half metre does not count any more";
}

}  // namespace
}  // namespace lidar_mapping::localization::test
