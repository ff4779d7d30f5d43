// SPDX-License-Identifier: BSD-3-Clause
#include "candidates/graph_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::loop_closing {

namespace {

constexpr double kUnconnected = std::numeric_limits<double>::infinity();

/// Lowers `distance` to the distance via a neighbour, if that is smaller. Returns true if it was.
bool relax(double& distance, double via_neighbour) {
  if (via_neighbour >= distance) return false;
  distance = via_neighbour;
  return true;
}

}  // namespace

void GraphDistance::append(double step) {
  if (std::isfinite(step)) {
    travelled_since_update_ += step;
  } else {
    std::fill(distance_.begin(), distance_.end(), kUnconnected);
    travelled_since_update_ = 0.0;
  }
  step_.push_back(step);
  distance_.push_back(-travelled_since_update_);
}

void GraphDistance::update_loops(const std::vector<LoopEdge>& links) {
  if (distance_.empty()) return;
  std::fill(distance_.begin(), distance_.end(), kUnconnected);
  distance_.back() = 0.0;
  travelled_since_update_ = 0.0;
  // A shortest path has fewer edges than there are nodes, and a round follows at least one more of
  // them. Most ways through loops need a handful of rounds.
  bool changed = true;
  for (std::size_t round = 0; round < distance_.size() && changed; ++round) {
    changed = false;
    for (std::size_t i = distance_.size() - 1; i > 0; --i) {
      changed |= relax(distance_[i - 1], distance_[i] + step_[i]);
    }
    for (std::size_t i = 1; i < distance_.size(); ++i)
      changed |= relax(distance_[i], distance_[i - 1] + step_[i]);
    for (const auto& [a, b] : links) {
      changed |= relax(distance_[a], distance_[b]);
      changed |= relax(distance_[b], distance_[a]);
    }
  }
}

}  // namespace lidar_mapping::loop_closing
