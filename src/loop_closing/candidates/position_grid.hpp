// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Horizontal positions in square cells. The cost of a search depends on the number of results, and
/// a position that moves changes at most two cells. Nodes are numbered from 0 without gaps.
class PositionGrid {
 public:
  /// Sets or changes the position (m) of a node.
  void set_position(std::size_t node, const Eigen::Vector2d& position);
  bool has(std::size_t node) const {
    return node < positions_.size() && !positions_[node].hasNaN();
  }
  const Eigen::Vector2d& position(std::size_t node) const { return positions_[node]; }
  /// All nodes within `radius` (m) of `centre`, ordered by number.
  std::vector<std::size_t> within(const Eigen::Vector2d& centre, double radius) const;

 private:
  using Key = std::uint64_t;
  static Key key_of(const Eigen::Vector2d& position);
  std::vector<std::size_t> nodes_around(const Eigen::Vector2d& centre, double radius) const;

  std::unordered_map<Key, std::vector<std::size_t>> cells_;
  std::vector<Eigen::Vector2d> positions_;  // NaN for a node without a position
};

}  // namespace lidar_mapping::loop_closing
