// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
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

/// The appearance of the surroundings of a key frame, about 8 kB.
struct Appearance {
  BirdsEyeView view;              ///< occupied cells, seen from above
  SpectrumDescriptor descriptor;  ///< descriptor computed from these cells
};

/// Computes the appearance from the points of a key frame in base_link, m.
Appearance appearance_of(const std::vector<Eigen::Vector3f>& points);

/// The two headings (rad) of the newer in the older scan that the descriptors allow.
std::array<double, 2> headings_by_views(const Appearance& older, const Appearance& newer);

/// The appearances of all key frames of a drive. One is appended per key frame; the index is never
/// rebuilt. A search goes linearly over coarse keys of some hundred bytes each, which are held in
/// memory. The full appearances are in a temporary file without a name. All functions throw
/// FileError.
class AppearanceIndex {
 public:
  /// The file is created in `directory` with the first appearance.
  explicit AppearanceIndex(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Appends the appearance of the next node; empty if the node has no cloud. If it cannot be
  /// stored, the node counts without it.
  void append(const std::optional<Appearance>& appearance);
  /// The appearance of a node, read from the file; empty if there is none.
  std::optional<Appearance> operator[](std::size_t node) const;

  /// The nodes most similar to the newest one, best first. Only nodes for which `is_admissible`
  /// returns true are considered.
  std::vector<std::size_t> similar_to_newest(
      const std::function<bool(std::size_t)>& is_admissible) const;
  /// At most `count` nodes that look most like an appearance which is not in the index, best first:
  /// the `nearest` nodes by their keys are compared.
  std::vector<std::size_t> similar_to(const Appearance& appearance, std::size_t nearest,
                                      std::size_t count) const;

 private:
  using IsAdmissible = std::function<bool(std::size_t)>;
  SpectrumDescriptor::Key key_of(std::size_t node) const;
  std::vector<std::size_t> possible_nearest(const CoarseKey& key, std::size_t count,
                                            const IsAdmissible& is_admissible) const;
  std::vector<std::size_t> nearest_keys(const SpectrumDescriptor::Key& key, std::size_t count,
                                        const IsAdmissible& is_admissible) const;
  std::vector<std::size_t> most_similar(const SpectrumDescriptor& descriptor,
                                        const std::vector<std::size_t>& nodes,
                                        std::size_t count) const;

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::vector<std::optional<CoarseKey>> coarse_keys_;
};

}  // namespace lidar_mapping::loop_closing
