// SPDX-License-Identifier: BSD-3-Clause
#include "correspondence_cache.hpp"

#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

constexpr float kRounding = 1e-3F;  // m; what single precision may be off some hundred metres away

}  // namespace

/// The nearest may have come nearer, or gone away, by what the point moved, and so may all others.
bool CorrespondenceCache::still_holds(const Known& known, const Eigen::Vector3f& p, float limit) {
  const float room = known.found ? 0.5F * known.lead : known.lead - limit;
  if (room <= kRounding) return false;
  return (p - known.p).squaredNorm() < (room - kRounding) * (room - kRounding);
}

void CorrespondenceCache::search(Known& known, const Eigen::Vector3f& p, float limit) const {
  const auto result = tree_.nearest_with_lead(p, limit);
  known.p = p;
  known.found = result.has_value();
  known.lead = limit;
  if (!result) return;
  known.index = result->nearest.index;
  known.lead = std::sqrt(result->next_squared) - std::sqrt(result->nearest.squared_distance);
}

std::optional<KdTree::Neighbour> CorrespondenceCache::nearest(std::size_t i,
                                                              const Eigen::Vector3f& p,
                                                              float limit) {
  Known& known = known_[i];
  if (!still_holds(known, p, limit)) search(known, p, limit);
  if (!known.found) return std::nullopt;
  const float squared_distance = (tree_.points()[known.index] - p).squaredNorm();
  if (squared_distance >= limit * limit) return std::nullopt;
  return KdTree::Neighbour{known.index, squared_distance};
}

}  // namespace lidar_mapping::loop_closing
