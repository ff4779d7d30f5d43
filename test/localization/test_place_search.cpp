// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"

#include "map_parts.hpp"
#include "near.hpp"
#include "recent_scans.hpp"
#include "toy_map.hpp"

namespace lidar_mapping::localization::test {
namespace {

using lidar_mapping::test::near;

class Search : public testing::Test {
 protected:
  void see(const Pose& truth) { recent_.add(town().scan(truth, 9), truth, ToyWorld::sensor()); }

  PlaceSearch& places_ = town_map().parts().places;
  RecentScans recent_{0.4, 0.4};
};

TEST_F(Search, NamesTheTruePlaceAmongFewCandidates) {
  const Pose truth = planar(-20.0, 1.5, 2.8);
  see(truth);
  const std::vector<Pose> candidates = places_.candidates(recent_.newest());
  EXPECT_LE(candidates.size(), 8U);
  EXPECT_TRUE(std::any_of(candidates.begin(), candidates.end(),
                          [&](const Pose& pose) { return is_same_place(pose, truth); }));
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    EXPECT_FALSE(is_same_place(candidates[i - 1], candidates[i]));
  }
}

// With an empty view there is no pose at which it agrees; the origin of the map is none.
TEST_F(Search, NamesNoPlaceForBareGround) {
  recent_.add(ToyWorld().scan(Pose::Identity(), 9), Pose::Identity(), ToyWorld::sensor());
  ASSERT_FALSE(recent_.newest().empty());
  EXPECT_TRUE(places_.candidates(recent_.newest()).empty());
}

TEST_F(Search, VerifiesTheTruePlaceAlone) {
  const Pose truth = planar(-20.0, 1.5, 2.8);
  see(truth);
  places_.set_query(recent_.query());
  const auto here = places_.verified(planar(-19.0, 1.0, 2.75));
  ASSERT_TRUE(here.has_value());
  EXPECT_TRUE(near(here->T_map_base, truth, 0.15, 0.01));
  EXPECT_TRUE(is_valid_covariance(here->covariance));
  EXPECT_FALSE(places_.verified(planar(48.0, 60.0, 2.8)).has_value());
}

TEST_F(Search, LooksAroundAClaimedPose) {
  const Pose truth = planar(-20.0, 1.5, 0.1);
  see(truth);
  const Pose claimed = planar(-27.0, 0.0, 0.1);  // further off than a match converges
  const std::vector<Pose> near_it = places_.candidates_near(claimed, recent_.newest());
  ASSERT_EQ(near_it.size(), 2U);
  EXPECT_TRUE(near(near_it.front(), claimed, 1e-9));
  EXPECT_TRUE(is_same_place(near_it.back(), truth));
}

TEST(RecentScans, MergesScansThatAreSomeDistanceApart) {
  const ToyWorld world = make_town(100.0, 48.0, 3);
  RecentScans recent(0.4, 0.4);
  recent.add(world.scan(planar(0.0, 0.0, 0.0), 1), planar(0.0, 0.0, 0.0), ToyWorld::sensor());
  const std::size_t alone = recent.query().surroundings.size();
  recent.add(world.scan(planar(0.0, 0.0, 0.0), 2), planar(0.1, 0.0, 0.0), ToyWorld::sensor());
  recent.add(world.scan(planar(3.0, 0.0, 0.0), 3), planar(3.0, 0.0, 0.0), ToyWorld::sensor());
  const loop_closing::PlaceQuery query = recent.query();
  EXPECT_GT(query.surroundings.size(), alone * 5 / 4);
  EXPECT_EQ(query.scan.size(), recent.newest().size());
  EXPECT_EQ(query.p_base_lidar, ToyWorld::sensor());
}

// Odometry does not lead from a scan before an interruption to those after it.
TEST(RecentScans, DiscardTheNewestScanToo) {
  const ToyWorld world = make_town(100.0, 48.0, 3);
  RecentScans recent(0.4, 0.4), fresh(0.4, 0.4);
  recent.add(world.scan(planar(0.0, 0.0, 0.0), 1), planar(0.0, 0.0, 0.0), ToyWorld::sensor());
  recent.clear();
  for (RecentScans* scans : {&recent, &fresh}) {
    scans->add(world.scan(planar(40.0, 0.0, 0.0), 2), planar(0.5, 0.0, 0.0), ToyWorld::sensor());
  }
  EXPECT_EQ(recent.query().surroundings.size(), fresh.query().surroundings.size());
}

}  // namespace
}  // namespace lidar_mapping::localization::test
