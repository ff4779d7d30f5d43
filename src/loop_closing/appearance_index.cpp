// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "surface.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Chosen: with fewer the true place may be missing, each more costs a correlation.
constexpr std::size_t kNearestKeys = 25;
// Chosen: with fewer the true place may be missing, each more is compared from above.
constexpr std::size_t kMaxSimilar = 10;
using Key = SpectrumDescriptor::Key;

/// A record of the file: plain values with the same layout in memory and in the file.
struct Stored {
  Key key;
  Appearance appearance;
};
static_assert(std::is_standard_layout_v<Stored> && std::is_trivially_destructible_v<Stored>);

struct Ranked {
  double cost;
  std::size_t node;
  bool operator<(const Ranked& other) const {
    return cost != other.cost ? cost < other.cost : node < other.node;
  }
};

std::vector<std::size_t> best_of(std::vector<Ranked> ranked, std::size_t count) {
  count = std::min(count, ranked.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count),
                    ranked.end());
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i < count; ++i) nodes.push_back(ranked[i].node);
  return nodes;
}

}  // namespace

Appearance appearance_of(const std::vector<Eigen::Vector3f>& points) {
  Appearance appearance;
  appearance.view = BirdsEyeView(points, above_ground(points));
  appearance.descriptor = SpectrumDescriptor(appearance.view.cells());
  return appearance;
}

void AppearanceIndex::append(const std::optional<Appearance>& appearance) {
  if (!appearance) {
    coarse_keys_.emplace_back();
    return;
  }
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  const Stored stored{appearance->descriptor.key(), *appearance};
  file_->write(coarse_keys_.size() * sizeof(Stored), &stored, sizeof(Stored));
  coarse_keys_.emplace_back(stored.key);
}

std::optional<Appearance> AppearanceIndex::operator[](std::size_t node) const {
  if (!coarse_keys_[node]) return std::nullopt;
  Appearance appearance;
  file_->read(node * sizeof(Stored) + offsetof(Stored, appearance), &appearance,
              sizeof(Appearance));
  return appearance;
}

Key AppearanceIndex::key_of(std::size_t node) const {
  Key key;
  file_->read(node * sizeof(Stored) + offsetof(Stored, key), &key, sizeof(Key));
  return key;
}

/// All nodes whose keys may be among the nearest, as far as the bounds of the coarse keys tell.
std::vector<std::size_t> AppearanceIndex::possible_nearest(
    const std::function<bool(std::size_t)>& is_admissible) const {
  std::vector<std::pair<std::size_t, CoarseKey::Bounds>> bounds;
  for (std::size_t node = 0; node + 1 < coarse_keys_.size(); ++node) {
    if (!coarse_keys_[node] || !is_admissible(node)) continue;
    bounds.emplace_back(node, coarse_keys_[node]->distance_to(*coarse_keys_.back()));
  }
  std::vector<float> upper;
  for (const auto& [node, bound] : bounds) upper.push_back(bound.upper);
  std::vector<std::size_t> nodes;
  if (upper.size() > kNearestKeys) {
    std::nth_element(upper.begin(), upper.begin() + kNearestKeys - 1, upper.end());
  }
  for (const auto& [node, bound] : bounds) {
    if (upper.size() <= kNearestKeys || bound.lower <= upper[kNearestKeys - 1]) {
      nodes.push_back(node);
    }
  }
  return nodes;
}

std::vector<std::size_t> AppearanceIndex::nearest_keys(
    const std::function<bool(std::size_t)>& is_admissible) const {
  const Key newest = key_of(coarse_keys_.size() - 1);
  std::vector<Ranked> ranked;
  for (const std::size_t node : possible_nearest(is_admissible)) {
    ranked.push_back({(key_of(node) - newest).squaredNorm(), node});
  }
  return best_of(std::move(ranked), kNearestKeys);
}

std::vector<std::size_t> AppearanceIndex::similar_to_newest(
    const std::function<bool(std::size_t)>& is_admissible) const {
  if (coarse_keys_.empty() || !coarse_keys_.back()) return {};
  const Appearance newest = *(*this)[coarse_keys_.size() - 1];
  std::vector<Ranked> ranked;
  for (const std::size_t node : nearest_keys(is_admissible)) {
    const auto comparison = (*this)[node]->descriptor.compare(newest.descriptor);
    ranked.push_back({-comparison.similarity, node});
  }
  return best_of(std::move(ranked), kMaxSimilar);
}

}  // namespace lidar_mapping::loop_closing
