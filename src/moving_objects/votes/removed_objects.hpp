// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "lidar_mapping/moving_objects/transformed_points.hpp"

#include "votes/moving_points.hpp"
#include "votes/vote_count.hpp"

namespace lidar_mapping::moving_objects {

/// Numbers of cells, stored in pages that are created on demand, because most cells have none.
class CellNumbers {
 public:
  static constexpr std::uint32_t kNone = 0;  // no object, because their numbers begin with 1

  explicit CellNumbers(std::size_t cells) : pages_(cells / kPage + 1, kNoPage) {}

  void set(std::uint32_t cell, std::uint32_t number) {
    std::uint32_t& page = pages_[cell / kPage];
    if (page == kNoPage) {
      page = static_cast<std::uint32_t>(numbers_.size());
      numbers_.resize(numbers_.size() + kPage, kNone);
    }
    numbers_[page + cell % kPage] = number;
  }
  std::uint32_t at(std::uint32_t cell) const {
    const std::uint32_t page = pages_[cell / kPage];
    return page == kNoPage ? kNone : numbers_[page + cell % kPage];
  }

 private:
  // Cells, 128 bytes; chosen: memory of sparse pages against number of pages.
  static constexpr std::uint32_t kPage = 32;
  static constexpr std::uint32_t kNoPage = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> pages_;  ///< Begin of each page in numbers_.
  std::vector<std::uint32_t> numbers_;
};

/// Objects that stand alone, seen from above: occupied cells that touch, also at corners. Only
/// objects are searched of which some point is voted moving.
class RemovedObjects {
 public:
  RemovedObjects(const TransformedPoints& points, const std::vector<Vote>& votes,
                 const std::vector<Layer>& layers);

  /// Whether the object with the i-th point is removed as a whole.
  bool contains(std::size_t i) const { return is_inside(i) && removed_[cells_of_points_[i]]; }

  /// Whether an object that is removed stands in the cell of the i-th point or in a neighbouring
  /// one.
  bool touches(std::size_t i) const {
    return is_inside(i) && removed_or_adjacent_[cells_of_points_[i]];
  }

 private:
  RemovedObjects(const PointCells& cells, const std::vector<Vote>& votes,
                 const std::vector<Layer>& layers);
  bool is_inside(std::size_t i) const { return cells_of_points_[i] != CellRectangle::kOutside; }

  void grow_object(std::uint32_t first);
  void mark_removed(std::uint32_t cell);
  /// The 3x3 cells around a cell; occupied cells are never at the edge of the area.
  std::array<std::uint32_t, 9> block_around(std::uint32_t cell) const;

  const CellRectangle area_;
  const std::vector<std::uint32_t> cells_of_points_;
  std::vector<bool> occupied_;  ///< For each cell of the area.
  CellNumbers objects_;
  std::vector<std::uint32_t> object_cells_;  ///< Cells of the objects, one object after the other.
  std::vector<VoteCount> vote_counts_;  ///< Vote counts of the objects, whose numbers begin with 1.
  std::vector<bool> removed_;
  std::vector<bool> removed_or_adjacent_;  ///< Cells of removed objects and their neighbours.
};

}  // namespace lidar_mapping::moving_objects
