#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "lidar_mapping/loop_closing/birds_eye.hpp"
#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

namespace lidar_mapping::loop_closing {

/// How a key frame's surroundings look: about 8 kB.
struct Appearance {
  BirdsEye view;
  SpectrumDescriptor descriptor;
};

/// Of the points of a key frame in base_link.
Appearance appearance_of(const std::vector<Eigen::Vector3f>& points);

/// All appearances of a drive. Grows by one per key frame, is never rebuilt, and is searched by a
/// linear scan over keys (0.3 ms per 2000 key frames).
class AppearanceIndex {
 public:
  /// The next node's; empty if it has no cloud.
  void append(std::optional<Appearance> appearance);
  const std::optional<Appearance>& operator[](std::size_t node) const { return all_[node]; }

  /// The nodes that look most like the newest one among those that `admits`, best first.
  std::vector<std::size_t> similar_to_newest(const std::function<bool(std::size_t)>& admits) const;

 private:
  std::vector<std::size_t> nearest_keys(const std::function<bool(std::size_t)>& admits) const;

  std::vector<std::optional<Appearance>> all_;
  std::vector<float> keys_;  // one after the other
};

}  // namespace lidar_mapping::loop_closing
