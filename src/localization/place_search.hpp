// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/loop_closing/appearance_index.hpp"
#include "lidar_mapping/loop_closing/place_verifier.hpp"

#include "map_matcher.hpp"

namespace lidar_mapping::localization {

/// The same place within so much: a distance (m), a height (m) and a heading (rad).
bool is_same_place(const Pose& a, const Pose& b);

/// Finds places of the map that look like a scan, and verifies them.
class PlaceSearch {
 public:
  /// `key_frames` have the poses `places`. `clouds` must outlive this object.
  PlaceSearch(const loop_closing::LoopClosingConfig& verification, CloudSource& clouds,
              const std::vector<KeyFrame>& key_frames, std::vector<Pose> places,
              const Eigen::Vector3d& p_base_lidar, const std::filesystem::path& directory);

  const std::vector<Pose>& places() const { return places_; }
  const loop_closing::LoopClosingConfig& verification() const { return verification_; }
  /// The points and the appearance of the next place; none without a cloud.
  void append(const loop_closing::PreparedKeyFrame& prepared);

  /// Poses T_map_base of a scan that looks like these points, best first, none twice.
  std::vector<Pose> candidates(const loop_closing::Points& points) const;
  /// Poses near one that a person claims: it, the same at the height of the nearest place, because
  /// who clicks on a map from above gives none, and where the views from above agree with its
  /// heading.
  std::vector<Pose> candidates_near(const Pose& claimed, const loop_closing::Points& points) const;

  /// The scan that verified() is about.
  void set_query(const loop_closing::PlaceQuery& query) { verifier_.set_query(query); }
  /// The scan's pose in the map, matched from a guess; none if it is not accepted.
  std::optional<PoseEstimate> verified(const Pose& T_map_base_guess);

 private:
  struct Start {
    Pose T_map_base;
    double score = 0.0;
  };
  std::size_t nearest_place(const Pose& T_map_base, double height_weight) const;
  Pose at_height_of_map(const Pose& T_map_base) const;
  void add_candidates_at(const Pose& claimed, const loop_closing::Points& points,
                         std::vector<Pose>& poses) const;
  Start start_at(std::size_t place, const loop_closing::Appearance& appearance,
                 const std::vector<Eigen::Vector2f>& cells) const;

  loop_closing::LoopClosingConfig verification_;
  std::vector<Pose> places_;
  loop_closing::AppearanceIndex appearances_;
  loop_closing::PlaceVerifier verifier_;
  std::size_t appended_ = 0;  ///< places
};

}  // namespace lidar_mapping::localization
