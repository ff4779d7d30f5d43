// SPDX-License-Identifier: BSD-3-Clause
#include "separation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::loop_closing {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr int kMaxRounds = 8;  // loops in a row of one shortest way

/// Lowers `way` to what it is by way of a neighbour.
bool relax(double& way, double by_neighbour) {
  if (by_neighbour >= way) return false;
  way = by_neighbour;
  return true;
}

}  // namespace

void Separation::append(double step) {
  if (std::isfinite(step)) {
    since_ += step;
  } else {
    std::fill(way_.begin(), way_.end(), kUnknown);
    since_ = 0.0;
  }
  step_.push_back(step);
  way_.push_back(-since_);
}

void Separation::relink(const std::vector<Link>& links) {
  if (way_.empty()) return;
  std::fill(way_.begin(), way_.end(), kUnknown);
  way_.back() = 0.0;
  since_ = 0.0;
  bool changed = true;
  for (int round = 0; round < kMaxRounds && changed; ++round) {
    changed = false;
    for (std::size_t i = way_.size() - 1; i > 0; --i) {
      changed |= relax(way_[i - 1], way_[i] + step_[i]);
    }
    for (std::size_t i = 1; i < way_.size(); ++i) changed |= relax(way_[i], way_[i - 1] + step_[i]);
    for (const auto& [a, b] : links) {
      changed |= relax(way_[a], way_[b]);
      changed |= relax(way_[b], way_[a]);
    }
  }
}

}  // namespace lidar_mapping::loop_closing
