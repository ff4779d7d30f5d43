#include "lidar_mapping/loop_closing/appearance_index.hpp"

#include <algorithm>

#include "lidar_mapping/loop_closing/surface.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr std::size_t kNearestKeys = 25;
constexpr std::size_t kMostSimilar = 10;
using Key = SpectrumDescriptor::Key;

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
  appearance.view = BirdsEye(points, above_ground(points));
  appearance.descriptor = SpectrumDescriptor(appearance.view.cells());
  return appearance;
}

void AppearanceIndex::append(std::optional<Appearance> appearance) {
  const Key key = appearance ? appearance->descriptor.key() : Key::Zero();
  keys_.insert(keys_.end(), key.data(), key.data() + key.size());
  all_.push_back(std::move(appearance));
}

std::vector<std::size_t> AppearanceIndex::nearest_keys(
    const std::function<bool(std::size_t)>& admits) const {
  const auto key_of = [this](std::size_t node) {
    return Eigen::Map<const Key>(&keys_[node * Key::SizeAtCompileTime]);
  };
  const Key newest = key_of(all_.size() - 1);
  std::vector<Ranked> ranked;
  for (std::size_t node = 0; node + 1 < all_.size(); ++node) {
    if (!all_[node] || !admits(node)) continue;
    ranked.push_back({(key_of(node) - newest).squaredNorm(), node});
  }
  return best_of(std::move(ranked), kNearestKeys);
}

std::vector<std::size_t> AppearanceIndex::similar_to_newest(
    const std::function<bool(std::size_t)>& admits) const {
  if (all_.empty() || !all_.back()) return {};
  std::vector<Ranked> ranked;
  for (const std::size_t node : nearest_keys(admits)) {
    const auto comparison = all_[node]->descriptor.compare(all_.back()->descriptor);
    ranked.push_back({-comparison.similarity, node});
  }
  return best_of(std::move(ranked), kMostSimilar);
}

}  // namespace lidar_mapping::loop_closing
