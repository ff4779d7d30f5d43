// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "votes/voxel_votes.hpp"

namespace lidar_mapping::moving_objects {
namespace {

TransformedPoints points_at(const std::vector<Eigen::Vector3f>& positions,
                            const Pose& T_map_base = Pose()) {
  PointCloud cloud;
  for (const Eigen::Vector3f& p : positions) cloud.points.push_back({p.x(), p.y(), p.z(), 0.0F});
  return {cloud, T_map_base};
}

/// m: moving, s: static, -: nobody saw it.
std::vector<Vote> votes(const std::string& letters) {
  std::vector<Vote> result;
  for (const char letter : letters) {
    result.push_back(letter == 'm' ? Vote::kMoving : letter == 's' ? Vote::kStatic : Vote::kUnseen);
  }
  return result;
}

TEST(VoteCount, CountsVotersAndThoseThatVoteMoving) {
  VoteCount sum;
  for (const Vote vote : votes("mmms-")) sum.add(vote_count_of(vote));
  EXPECT_EQ(sum.voters, 4);
  EXPECT_EQ(sum.moving, 3);
  EXPECT_TRUE(sum.is_moving(0.7));
  EXPECT_FALSE(sum.is_moving(0.75)) << "more than this fraction";
  EXPECT_FALSE(VoteCount().is_moving(0.0)) << "nobody";
}

TEST(VoxelKeys, GiveAVoxelAndTheColumnThatItStandsIn) {
  const TransformedPoints points = points_at({{0.1F, 0.1F, 0.1F},
                                              {0.3F, 0.3F, 0.3F},
                                              {0.1F, 0.1F, 5.0F},
                                              {-0.1F, 0.1F, 0.1F},
                                              {0.1F, -0.1F, 0.1F}});
  const VoxelKeys keys(points, 0.4F);
  EXPECT_EQ(keys.of(0), keys.of(1));
  EXPECT_NE(keys.of(0), keys.of(2));
  EXPECT_EQ(keys.column_of(0), keys.column_of(2));
  EXPECT_NE(keys.column_of(0), keys.column_of(3)) << "on the other side of zero";
  EXPECT_NE(keys.column_of(0), keys.column_of(4));
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(VoxelKeys::column_of_key(keys.of(i)), keys.column_of(i)) << i;
  }
}

TEST(ColumnFilter, HoldsTheColumnsUpToADistance) {
  ColumnFilter filter;
  filter.add_around(voxel_key({-1, 2, 7}), 2);
  for (int x = -5; x <= 5; ++x) {
    for (int y = -5; y <= 5; ++y) {
      const bool is_near = std::abs(x + 1) <= 2 && std::abs(y - 2) <= 2;
      EXPECT_EQ(filter.may_contain(VoxelKeys::column_of_key(voxel_key({x, y, -30}))), is_near)
          << x << " " << y;
    }
  }
}

TEST(NeighbourCounter, CountsPointsInThreeVoxelsOfTwentyCentimetresEachWay) {
  // The candidate lies in the voxel from 1.0 to 1.2 m, so that 0.8 to 1.4 m count.
  const TransformedPoints points = points_at({{1.1F, 1.1F, 1.1F},
                                              {1.15F, 1.1F, 1.1F},
                                              {0.85F, 0.85F, 0.85F},
                                              {1.35F, 1.35F, 1.35F},
                                              {0.75F, 1.1F, 1.1F},
                                              {1.1F, 1.45F, 1.1F},
                                              {1.1F, 1.1F, 1.45F}});
  const NeighbourCounter counter(points, votes("ms-s---"));
  EXPECT_EQ(counter.around(0), 4) << "whatever they vote, itself included";
}

TEST(NeighbourCounter, CountsNothingIfNothingMoves) {
  const TransformedPoints points = points_at({{1.1F, 1.1F, 1.1F}, {1.15F, 1.1F, 1.1F}});
  EXPECT_EQ(NeighbourCounter(points, votes("ss")).around(0), 0);
}

TEST(NeighbourCounter, CountsInTheAxesOfTheMap) {
  const Pose T_map_base{exp_so3({0.0, 0.0, 0.7}), {1234.5, -987.6, 3.0}};
  const TransformedPoints points = points_at({{1.1F, 1.1F, 1.1F}, {1.15F, 1.1F, 1.1F}}, T_map_base);
  EXPECT_EQ(NeighbourCounter(points, votes("mm")).around(0), 2);
}

/// Whether the block around the first point moves, of points close to each other.
bool moves(const std::string& letters) {
  std::vector<Eigen::Vector3f> positions;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    positions.emplace_back(2.05F + 0.03F * static_cast<float>(i), 2.2F, 2.2F);
  }
  const TransformedPoints points = points_at(positions);
  return VoteBlocks(points, votes(letters)).is_moving_around(0);
}

TEST(VoteBlocks, MoveIfMoreThanSevenOfTenVotersSaySo) {
  EXPECT_TRUE(moves("mmmmmmmmss"));
  EXPECT_FALSE(moves("mmmmmmmsss"));
  EXPECT_TRUE(moves("mmmmmmmmss------")) << "who sees nothing has no vote";
  EXPECT_TRUE(moves("m"));
  EXPECT_FALSE(moves("s"));
}

TEST(VoteBlocks, ReachOneVoxelOfFortyCentimetresEachWay) {
  // The voxel of the first point reaches from 2.0 to 2.4 m: voters from 1.6 to 2.8 m count.
  const auto first_moves = [](const Eigen::Vector3f& other) {
    const TransformedPoints points = points_at({{2.2F, 2.2F, 2.2F}, other});
    return VoteBlocks(points, votes("ms")).is_moving_around(0);
  };
  EXPECT_FALSE(first_moves({2.75F, 2.75F, 2.75F}));
  EXPECT_FALSE(first_moves({1.65F, 1.65F, 1.65F}));
  EXPECT_TRUE(first_moves({2.85F, 2.2F, 2.2F}));
  EXPECT_TRUE(first_moves({2.2F, 1.55F, 2.2F}));
  EXPECT_TRUE(first_moves({2.2F, 2.2F, 2.85F}));
}

TEST(VoteBlocks, TakeUnseenPointsAlongThatAreAmongThem) {
  const TransformedPoints points =
      points_at({{2.2F, 2.2F, 2.2F}, {2.5F, 2.2F, 2.2F}, {5.0F, 2.2F, 2.2F}});
  const VoteBlocks blocks(points, votes("m--"));
  EXPECT_FALSE(blocks.empty());
  EXPECT_TRUE(blocks.is_moving_around(1));
  EXPECT_FALSE(blocks.is_moving_around(2));
  EXPECT_TRUE(VoteBlocks(points, votes("s--")).empty());
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
