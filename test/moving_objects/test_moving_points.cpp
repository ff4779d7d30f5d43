// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "votes/moving_points.hpp"

namespace lidar_mapping::moving_objects {
namespace {

using Indices = std::vector<std::uint32_t>;

void add(PointCloud& cloud, double x, double y, double z) {
  cloud.points.push_back(
      {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0.0F});
}

/// A level surface at this height, a point every 0.2 m within 6 m of the origin.
PointCloud level(double z) {
  PointCloud cloud;
  for (int i = -30; i < 30; ++i) {
    for (int j = -30; j < 30; ++j) add(cloud, 0.2 * i + 0.1, 0.2 * j + 0.1, z);
  }
  return cloud;
}

/// Layer of a point this far above the origin, with the heights at which the own key frame, its
/// neighbours and key frames further away saw the ground.
Layer layer_at(double z, double own, double near, double wide) {
  PointCloud cloud = level(own);
  add(cloud, 0.1, 0.1, z);
  const TransformedPoints points(cloud, Pose());
  GroundModels models(points);
  models.own.add(ground_columns(TransformedPoints(level(own), Pose())));
  models.near.add(ground_columns(TransformedPoints(level(near), Pose())));
  models.wide.add(ground_columns(TransformedPoints(level(wide), Pose())));
  return classify_layers(points, models).back();
}

TEST(Layers, GoByTheHeightAboveTheGround) {
  for (const double ground : {0.0, -1.7, 250.0}) {
    const auto above = [&](double z) { return layer_at(ground + z, ground, ground, ground); };
    EXPECT_EQ(above(0.0), Layer::kGround);
    EXPECT_EQ(above(-0.5), Layer::kGround) << "below the ground";
    EXPECT_EQ(above(0.03), Layer::kGround) << "within the noise of the ranges";
    EXPECT_EQ(above(0.06), Layer::kBase);
    EXPECT_EQ(above(0.1), Layer::kBase) << "as high as a kerb";
    EXPECT_EQ(above(0.15), Layer::kBody);
    EXPECT_EQ(above(2.4), Layer::kBody) << "a van";
    EXPECT_EQ(above(2.6), Layer::kAbove) << "a branch";
  }
}

// The pose of the own key frame is some centimetres too high.
TEST(Layers, BelieveTheOwnGroundIfOthersAreALittleLower) {
  EXPECT_EQ(layer_at(0.08, 0.08, 0.0, 0.0), Layer::kRaised);
  EXPECT_EQ(layer_at(0.18, 0.08, 0.0, 0.0), Layer::kBase) << "10 cm above its own ground";
  EXPECT_EQ(layer_at(0.28, 0.08, 0.0, 0.0), Layer::kBody);
}

// All that it saw there is the roof of a car that drives along with it.
TEST(Layers, TakeTheGroundOfTheNeighboursBelowARoof) {
  EXPECT_EQ(layer_at(1.5, 1.5, 0.0, 0.0), Layer::kBody);
  EXPECT_EQ(layer_at(1.5, 1.5, 1.5, 1.5), Layer::kGround) << "a flat roof, for all that is known";
}

TEST(Layers, TakeTheGroundOfOthersIfNeighboursSawARoofToo) {
  EXPECT_EQ(layer_at(1.5, 1.5, 1.5, 0.0), Layer::kBody);
  EXPECT_EQ(layer_at(0.2, 0.2, 0.2, 0.0), Layer::kGround)
      << "lower than a bonnet: an error of a pose";
}

TEST(Layers, CountPointsOutOfRangeToTheGround) {
  PointCloud cloud = level(0.0);
  add(cloud, 2.0 * static_cast<double>(kMaxRange), 0.0, 5.0);
  const TransformedPoints points(cloud, Pose());
  GroundModels models(points);
  for (LocalGround* ground : {&models.own, &models.near, &models.wide}) {
    ground->add(ground_columns(points));
  }
  EXPECT_EQ(classify_layers(points, models).back(), Layer::kGround);
}

TEST(VotedPoints, StandAboveTheBase) {
  EXPECT_EQ(voted_points({Layer::kGround, Layer::kBody, Layer::kRaised, Layer::kAbove, Layer::kBase,
                          Layer::kBody}),
            (Indices{1, 3, 5}));
  EXPECT_TRUE(voted_points({}).empty());
}

/// Points with what is said of them.
struct Labelled {
  void add_point(double x, double y, double z, Layer layer, Vote vote) {
    add(cloud, x, y, z);
    layers.push_back(layer);
    votes.push_back(vote);
  }
  /// A box of body points, 0.6 m high, on a base.
  void add_box(double x, double y, double length, Vote vote) {
    for (double along = 0.05; along < length; along += 0.1) {
      add_point(x + along, y, 0.08, Layer::kBase, Vote::kUnseen);
      for (double z = 0.2; z < 0.8; z += 0.1) add_point(x + along, y, z, Layer::kBody, vote);
    }
  }
  TransformedPoints points(const Pose& T_map_base = Pose()) const { return {cloud, T_map_base}; }
  Indices moving() const { return moving_points(points(), votes, layers); }
  Indices outvoted() const { return outvoted_points(points(), votes, layers); }
  /// From the index of one point to that of another one.
  static Indices range(std::size_t begin, std::size_t end) {
    Indices indices;
    for (std::size_t i = begin; i < end; ++i) indices.push_back(static_cast<std::uint32_t>(i));
    return indices;
  }
  std::size_t size() const { return cloud.size(); }

  PointCloud cloud;
  std::vector<Layer> layers;
  std::vector<Vote> votes;
};

TEST(MovingPoints, AreNoneIfNothingWasSeenMoving) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 2.0, Vote::kStatic);
  scene.add_box(5.0, 3.0, 2.0, Vote::kUnseen);
  EXPECT_TRUE(scene.moving().empty());
  EXPECT_TRUE(scene.outvoted().empty());
  EXPECT_TRUE(Labelled().moving().empty());
}

TEST(MovingPoints, AreAnObjectWithItsBaseButNotTheGround) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 2.0, Vote::kMoving);
  const std::size_t end = scene.size();
  for (double x = 4.0; x < 8.0; x += 0.1) {
    scene.add_point(x, 0.0, 0.0, Layer::kGround, Vote::kUnseen);
  }
  scene.add_box(5.0, 4.0, 2.0, Vote::kStatic);
  EXPECT_EQ(scene.moving(), Labelled::range(0, end));
}

// A car of which only the rear was seen through: the whole car has driven away.
TEST(MovingPoints, AreAWholeObjectOfWhichAPartMoves) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 1.5, Vote::kMoving);
  scene.add_box(6.5, 0.0, 2.0, Vote::kStatic);
  const std::size_t end = scene.size();
  scene.add_box(12.0, 0.0, 2.0, Vote::kStatic);
  EXPECT_EQ(scene.moving(), Labelled::range(0, end));
  // Single points of a wall that were seen through by mistake take nothing along.
  Labelled wall;
  wall.add_box(5.0, 0.0, 0.2, Vote::kMoving);
  wall.add_box(5.2, 0.0, 6.0, Vote::kStatic);
  for (const std::uint32_t i : wall.moving()) EXPECT_LT(wall.cloud.points[i].x, 6.0F) << i;
}

TEST(MovingPoints, AreUnseenOnesThatBelongToAMovingObject) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 1.0, Vote::kMoving);
  scene.add_box(6.0, 0.0, 3.0, Vote::kUnseen);
  const std::size_t end = scene.size();
  scene.add_box(10.0, 0.0, 1.0, Vote::kUnseen);
  EXPECT_EQ(scene.moving(), Labelled::range(0, end));
}

// Neighbours saw the ground a little lower; under a car that is gone these points are its wheels.
TEST(MovingPoints, AreRaisedOnesOnlyBelowTheObjectItself) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 2.0, Vote::kMoving);
  const std::size_t end = scene.size();
  scene.add_point(6.0, 0.0, 0.03, Layer::kRaised, Vote::kUnseen);
  scene.add_point(6.0, 1.5, 0.03, Layer::kRaised, Vote::kUnseen);
  EXPECT_EQ(scene.moving(), Labelled::range(0, end + 1));
}

TEST(MovingPoints, AreAboveTheHeightOfCarsOnlyIfTheyMoveThemselves) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 2.0, Vote::kMoving);
  const std::size_t end = scene.size();
  scene.add_point(6.0, 0.0, 2.6, Layer::kAbove, Vote::kMoving);   // a tall lorry
  scene.add_point(6.0, 0.0, 4.0, Layer::kAbove, Vote::kStatic);   // a bridge above it
  scene.add_point(20.0, 0.0, 4.0, Layer::kAbove, Vote::kMoving);  // a branch in the wind
  EXPECT_EQ(scene.moving(), Labelled::range(0, end + 1));
}

TEST(MovingPoints, AreDropsOfRain) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 1.0, Vote::kMoving);
  const std::size_t end = scene.size();
  scene.add_point(9.0, 9.0, 1.5, Layer::kIsolated, Vote::kMoving);
  EXPECT_EQ(scene.moving(), Labelled::range(0, end + 1));
}

// Where the map begins is arbitrary; by whole steps of the grids, the cells are the same.
TEST(MovingPoints, DoNotChangeIfTheMapIsMoved) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 1.5, Vote::kMoving);
  scene.add_box(6.5, 0.0, 2.0, Vote::kStatic);
  scene.add_box(12.0, -3.0, 2.0, Vote::kStatic);
  Pose far;
  far.translation = {1200.0, -3600.0, 60.0};
  EXPECT_EQ(moving_points(scene.points(far), scene.votes, scene.layers), scene.moving());
  EXPECT_EQ(outvoted_points(scene.points(far), scene.votes, scene.layers), scene.outvoted());
}

// A shed that was taken down touches the house beside it, which stands.
TEST(OutvotedPoints, EndWhereTheVotesEnd) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 3.0, Vote::kMoving);
  scene.add_box(8.0, 0.0, 3.0, Vote::kStatic);
  const Indices outvoted = scene.outvoted();
  const auto is_out = [&](std::size_t i) {
    return std::find(outvoted.begin(), outvoted.end(), i) != outvoted.end();
  };
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const float x = scene.cloud.points[i].x;
    // In between, the blocks of voxels hold points of both.
    if (x < 7.0F || x > 8.5F) {
      EXPECT_EQ(is_out(i), x < 7.0F) << x;
    }
  }
  EXPECT_EQ(scene.moving(), Labelled::range(0, scene.size())) << "as one object";
}

TEST(OutvotedPoints, AreNeverTheGround) {
  Labelled scene;
  scene.add_box(5.0, 0.0, 2.0, Vote::kMoving);
  const std::size_t end = scene.size();
  for (double x = 5.0; x < 7.0; x += 0.1) {
    scene.add_point(x, 0.0, 0.0, Layer::kGround, Vote::kUnseen);
  }
  EXPECT_EQ(scene.outvoted(), Labelled::range(0, end));
}

TEST(IsolatedPoints, HaveAtMostOneNeighbour) {
  const auto isolated = [](const std::vector<double>& along, Vote first) {
    Labelled scene;
    for (const double x : along) {
      scene.add_point(x, 1.1, 1.1, Layer::kBody, scene.size() == 0 ? first : Vote::kUnseen);
    }
    return isolated_points(scene.points(), scene.votes);
  };
  EXPECT_EQ(isolated({1.1}, Vote::kMoving), Indices{0});
  EXPECT_EQ(isolated({1.1, 1.15}, Vote::kMoving), Indices{0});
  EXPECT_TRUE(isolated({1.1, 1.15, 1.05}, Vote::kMoving).empty());
  EXPECT_EQ(isolated({1.1, 3.0, 4.0, 5.0}, Vote::kMoving), Indices{0}) << "none of them is near";
  EXPECT_TRUE(isolated({1.1}, Vote::kStatic).empty());
  EXPECT_TRUE(isolated({1.1}, Vote::kUnseen).empty());
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
