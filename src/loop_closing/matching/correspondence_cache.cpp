// SPDX-License-Identifier: BSD-3-Clause
#include "matching/correspondence_cache.hpp"

#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

// m. Chosen above the error of single precision at some hundred metres (3e-5 m).
constexpr float kRounding = 1e-3F;

}  // namespace

/// The distances to the nearest point and to all others have changed by at most the motion of the
/// point.
bool CorrespondenceCache::is_still_valid(const CachedResult& cached, const Eigen::Vector3f& p,
                                         float limit) {
  const float allowed_motion = cached.found ? 0.5F * cached.margin : cached.margin - limit;
  if (allowed_motion <= kRounding) return false;
  return (p - cached.p).squaredNorm() < (allowed_motion - kRounding) * (allowed_motion - kRounding);
}

void CorrespondenceCache::search(CachedResult& cached, const Eigen::Vector3f& p,
                                 float limit) const {
  const auto result = tree_.nearest_with_second(p, limit);
  cached.p = p;
  cached.found = result.has_value();
  cached.margin = limit;
  if (!result) return;
  cached.index = result->nearest.index;
  cached.margin =
      std::sqrt(result->second_squared_distance) - std::sqrt(result->nearest.squared_distance);
}

std::optional<KdTree::Neighbour> CorrespondenceCache::nearest(std::size_t i,
                                                              const Eigen::Vector3f& p,
                                                              float limit) {
  CachedResult& cached = cached_[i];
  if (!is_still_valid(cached, p, limit)) search(cached, p, limit);
  if (!cached.found) return std::nullopt;
  const float squared_distance = (tree_.points()[cached.index] - p).squaredNorm();
  if (squared_distance >= limit * limit) return std::nullopt;
  return KdTree::Neighbour{cached.index, squared_distance};
}

}  // namespace lidar_mapping::loop_closing
