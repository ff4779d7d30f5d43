// SPDX-License-Identifier: BSD-3-Clause
#include "votes/removed_objects.hpp"

namespace lidar_mapping::moving_objects {

namespace {

// m, edge of a cell; cells that touch belong to one object. Chosen: gaps between the points of an
// object are smaller, those between parked cars larger.
constexpr double kObjectCell = 0.3;
// Voters of an object. Chosen: fewer do not remove a whole object.
constexpr int kMinVoters = 6;
// Fraction of the voters that have to vote moving. Chosen below kBlockFraction: a part of an object
// is enough, because next to nothing of a static object is seen through (doc/map.md).
constexpr double kObjectFraction = 0.3;

bool is_removed(const VoteCount& vote_count) {
  return vote_count.voters >= kMinVoters && vote_count.is_moving(kObjectFraction);
}

}  // namespace

RemovedObjects::RemovedObjects(const TransformedPoints& points, const std::vector<Vote>& votes,
                               const std::vector<Layer>& layers)
    : RemovedObjects(PointCells(points, kObjectCell, kMaxRange), votes, layers) {}

RemovedObjects::RemovedObjects(const PointCells& cells, const std::vector<Vote>& votes,
                               const std::vector<Layer>& layers)
    : area_(CellRectangle(cells, [&layers](std::size_t i) { return layers[i] == Layer::kBody; })
                .expanded(1)),
      cells_of_points_(area_.indices_of(cells)),
      occupied_(area_.size()),
      objects_(area_.size()),
      removed_(area_.size()),
      removed_or_adjacent_(area_.size()) {
  const auto for_each_body_point = [&](const auto& visit) {
    for (std::size_t i = 0; i < layers.size(); ++i) {
      if (layers[i] == Layer::kBody && is_inside(i)) visit(cells_of_points_[i], votes[i]);
    }
  };
  for_each_body_point([&](std::uint32_t cell, Vote) { occupied_[cell] = true; });
  for_each_body_point([&](std::uint32_t cell, Vote vote) {
    if (vote == Vote::kMoving && objects_.at(cell) == CellNumbers::kNone) grow_object(cell);
  });
  for_each_body_point([&](std::uint32_t cell, Vote vote) {
    const std::uint32_t object = objects_.at(cell);
    if (object != CellNumbers::kNone) vote_counts_[object - 1].add(vote_count_of(vote));
  });
  for (const std::uint32_t cell : object_cells_) {
    if (is_removed(vote_counts_[objects_.at(cell) - 1])) mark_removed(cell);
  }
}

void RemovedObjects::grow_object(std::uint32_t first) {
  vote_counts_.emplace_back();
  const auto object = static_cast<std::uint32_t>(vote_counts_.size());
  std::size_t next = object_cells_.size();
  const auto add_cell = [&](std::uint32_t cell) {
    objects_.set(cell, object);
    object_cells_.push_back(cell);
  };
  add_cell(first);
  for (; next < object_cells_.size(); ++next) {
    for (const std::uint32_t cell : block_around(object_cells_[next])) {
      if (occupied_[cell] && objects_.at(cell) == CellNumbers::kNone) add_cell(cell);
    }
  }
}

void RemovedObjects::mark_removed(std::uint32_t cell) {
  removed_[cell] = true;
  for (const std::uint32_t near : block_around(cell)) removed_or_adjacent_[near] = true;
}

std::array<std::uint32_t, 9> RemovedObjects::block_around(std::uint32_t cell) const {
  const auto width = static_cast<std::uint32_t>(area_.width());
  std::array<std::uint32_t, 9> block{};
  for (std::uint32_t n = 0; n < 9; ++n) block[n] = cell - width - 1 + n / 3 * width + n % 3;
  return block;
}

}  // namespace lidar_mapping::moving_objects
