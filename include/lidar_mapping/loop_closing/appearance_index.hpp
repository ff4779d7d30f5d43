// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/loop_closing/birds_eye_view.hpp"
#include "lidar_mapping/loop_closing/coarse_key.hpp"
#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

namespace lidar_mapping::loop_closing {

/// How a key frame's surroundings look: about 8 kB.
struct Appearance {
  BirdsEyeView view;
  SpectrumDescriptor descriptor;
};

/// Of the points of a key frame in base_link.
Appearance appearance_of(const std::vector<Eigen::Vector3f>& points);

/// All appearances of a drive. Grows by one per key frame, is never rebuilt, and is searched by a
/// linear scan over coarse keys: some hundred bytes of memory for each. The rest is in a nameless
/// file. Throws FileError.
class AppearanceIndex {
 public:
  /// The file is made in that folder with the first appearance.
  explicit AppearanceIndex(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// The next node's; empty if it has no cloud.
  void append(const std::optional<Appearance>& appearance);
  std::optional<Appearance> operator[](std::size_t node) const;

  /// The nodes that look most like the newest one among those that `admits`, best first.
  std::vector<std::size_t> similar_to_newest(
      const std::function<bool(std::size_t)>& is_admissible) const;

 private:
  SpectrumDescriptor::Key key_of(std::size_t node) const;
  std::vector<std::size_t> possible_nearest(
      const std::function<bool(std::size_t)>& is_admissible) const;
  std::vector<std::size_t> nearest_keys(
      const std::function<bool(std::size_t)>& is_admissible) const;

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::vector<std::optional<CoarseKey>> coarse_keys_;
};

}  // namespace lidar_mapping::loop_closing
