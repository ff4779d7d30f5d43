// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "lidar_mapping/common/units.hpp"

#include "matching/surface.hpp"

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

std::array<double, 2> headings_by_views(const Appearance& older, const Appearance& newer) {
  const double yaw = older.descriptor.compare(newer.descriptor).yaw;
  return {yaw, yaw + kPi};
}

void AppearanceIndex::append(const std::optional<Appearance>& appearance) {
  const std::size_t node = coarse_keys_.size();
  std::optional<CoarseKey>& coarse_key = coarse_keys_.emplace_back();
  if (!appearance) return;
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  const Stored stored{appearance->descriptor.key(), *appearance};
  file_->write(node * sizeof(Stored), &stored, sizeof(Stored));
  coarse_key.emplace(stored.key);
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

/// All nodes whose keys may be among the `count` nearest, as far as the bounds of the coarse keys
/// tell.
std::vector<std::size_t> AppearanceIndex::possible_nearest(
    const CoarseKey& key, std::size_t count, const IsAdmissible& is_admissible) const {
  std::vector<std::pair<std::size_t, CoarseKey::Bounds>> bounds;
  for (std::size_t node = 0; node < coarse_keys_.size(); ++node) {
    if (!coarse_keys_[node] || !is_admissible(node)) continue;
    bounds.emplace_back(node, coarse_keys_[node]->distance_to(key));
  }
  std::vector<float> upper;
  for (const auto& [node, bound] : bounds) upper.push_back(bound.upper);
  const bool are_all = upper.size() <= count;
  const auto last = static_cast<std::ptrdiff_t>(count) - 1;
  if (!are_all) std::nth_element(upper.begin(), upper.begin() + last, upper.end());
  std::vector<std::size_t> nodes;
  for (const auto& [node, bound] : bounds) {
    if (are_all || bound.lower <= upper[count - 1]) nodes.push_back(node);
  }
  return nodes;
}

std::vector<std::size_t> AppearanceIndex::nearest_keys(const Key& key, std::size_t count,
                                                       const IsAdmissible& is_admissible) const {
  std::vector<Ranked> ranked;
  for (const std::size_t node : possible_nearest(CoarseKey(key), count, is_admissible)) {
    ranked.push_back({(key_of(node) - key).squaredNorm(), node});
  }
  return best_of(std::move(ranked), count);
}

std::vector<std::size_t> AppearanceIndex::most_similar(const SpectrumDescriptor& descriptor,
                                                       const std::vector<std::size_t>& nodes,
                                                       std::size_t count) const {
  std::vector<Ranked> ranked;
  for (const std::size_t node : nodes) {
    ranked.push_back({-(*this)[node]->descriptor.compare(descriptor).similarity, node});
  }
  return best_of(std::move(ranked), count);
}

std::vector<std::size_t> AppearanceIndex::similar_to_newest(
    const IsAdmissible& is_admissible) const {
  if (coarse_keys_.empty() || !coarse_keys_.back()) return {};
  const std::size_t newest = coarse_keys_.size() - 1;
  const auto is_older = [&](std::size_t node) { return node < newest && is_admissible(node); };
  return most_similar((*this)[newest]->descriptor,
                      nearest_keys(key_of(newest), kNearestKeys, is_older), kMaxSimilar);
}

std::vector<std::size_t> AppearanceIndex::similar_to(const Appearance& appearance,
                                                     std::size_t nearest, std::size_t count) const {
  const auto all = [](std::size_t /*node*/) { return true; };
  const std::vector<std::size_t> nodes =
      nearest_keys(appearance.descriptor.key(), std::max<std::size_t>(1, nearest), all);
  return most_similar(appearance.descriptor, nodes, count);
}

}  // namespace lidar_mapping::loop_closing
