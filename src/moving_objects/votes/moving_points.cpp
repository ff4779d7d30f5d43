// SPDX-License-Identifier: BSD-3-Clause
#include "votes/moving_points.hpp"

#include <algorithm>
#include <cstdint>

#include "votes/removed_objects.hpp"
#include "votes/voxel_votes.hpp"

namespace lidar_mapping::moving_objects {

namespace {

// m, points below have no vote. Chosen: the height of a kerb; lower objects cannot be
// distinguished from errors of the ground.
constexpr float kGroundHeight = 0.12F;
// m. Chosen: above are branches that connect objects; cars and pedestrians are lower.
constexpr float kBodyHeight = 2.5F;
// m, nothing below is removed. Chosen: twice the range noise of a LiDAR (0.02 m).
constexpr float kBaseHeight = 0.04F;
// m; ground this much above that of more key frames is a roof. Chosen below the bonnet of a car.
constexpr float kRoofHeight = 0.3F;
// Points in the small voxels around an isolated point, itself included. Chosen: drops and flakes
// are hit once, at most with one neighbour.
constexpr int kMaxNeighbours = 2;

Layer layer_of(float above_own, float above_all) {
  if (above_all < kBaseHeight) return Layer::kGround;
  if (above_own < kBaseHeight && above_all < kGroundHeight) return Layer::kRaised;
  const float height =
      above_own < above_all - kRoofHeight ? above_all : std::min(above_own, above_all);
  if (height < kGroundHeight) return Layer::kBase;
  return height < kBodyHeight ? Layer::kBody : Layer::kAbove;
}

float height_above_all(float z, std::uint32_t column, GroundModels& ground_models) {
  const float near = ground_models.near.height_above(z, column);
  if (near >= kGroundHeight) return near;
  const float wide = ground_models.wide.height_above(z, column);
  return wide > near + kRoofHeight ? wide : near;
}

bool is_removed(std::size_t i, Layer layer, const VoteBlocks& blocks,
                const RemovedObjects& removed_objects) {
  switch (layer) {
    case Layer::kGround:
      return false;
    case Layer::kIsolated:
      return true;
    case Layer::kRaised:
      return removed_objects.contains(i);
    case Layer::kBase:
      return removed_objects.touches(i);
    case Layer::kBody:
      return blocks.is_moving_around(i) || removed_objects.contains(i);
    case Layer::kAbove:
      return blocks.is_moving_around(i) && removed_objects.contains(i);
  }
  return false;
}

/// The numbers, below `count`, of the points that are wanted.
template <typename IsWanted>
std::vector<std::uint32_t> numbers_of(std::size_t count, const IsWanted& is_wanted) {
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_wanted(i)) numbers.push_back(static_cast<std::uint32_t>(i));
  }
  return numbers;
}

}  // namespace

std::vector<Layer> classify_layers(const TransformedPoints& points, GroundModels& ground_models) {
  std::vector<Layer> layers(points.size());
  const auto origin_z = static_cast<float>(points.origin.z());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float z = origin_z + points.z[i];
    const std::uint32_t column = ground_models.area.column_of(i);
    const float above_all = height_above_all(z, column, ground_models);
    layers[i] = layer_of(ground_models.own.height_above(z, column), above_all);
  }
  return layers;
}

std::vector<std::uint32_t> voted_points(const std::vector<Layer>& layers) {
  return numbers_of(layers.size(), [&](std::size_t i) { return layers[i] >= Layer::kBody; });
}

std::vector<std::uint32_t> isolated_points(const TransformedPoints& points,
                                           const std::vector<Vote>& votes) {
  const NeighbourCounter neighbour_counts(points, votes);
  return numbers_of(points.size(), [&](std::size_t i) {
    return votes[i] == Vote::kMoving && neighbour_counts.around(i) <= kMaxNeighbours;
  });
}

std::vector<std::uint32_t> moving_points(const TransformedPoints& points,
                                         const std::vector<Vote>& votes,
                                         const std::vector<Layer>& layers) {
  const VoteBlocks blocks(points, votes);
  if (blocks.empty()) return {};
  const RemovedObjects removed_objects(points, votes, layers);
  return numbers_of(points.size(), [&](std::size_t i) {
    return is_removed(i, layers[i], blocks, removed_objects);
  });
}

std::vector<std::uint32_t> outvoted_points(const TransformedPoints& points,
                                           const std::vector<Vote>& votes,
                                           const std::vector<Layer>& layers) {
  const VoteBlocks blocks(points, votes);
  if (blocks.empty()) return {};
  return numbers_of(points.size(), [&](std::size_t i) {
    return layers[i] != Layer::kGround && blocks.is_moving_around(i);
  });
}

}  // namespace lidar_mapping::moving_objects
