// SPDX-License-Identifier: BSD-3-Clause
#include "place_search.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::localization {

namespace {

using loop_closing::Appearance;
using loop_closing::planar_pose;
using loop_closing::ViewCorrelator;
using loop_closing::ViewMatch;

/// Places by their keys that are compared, and the most similar of them that are looked at from
/// above. Chosen: several passes of a street have a key frame each two metres, and all places that
/// look alike have to be among them.
constexpr std::size_t kNearest = 200;
constexpr std::size_t kSimilar = 40;
/// Places that are verified in one search. Chosen: three streets alike with two passes each.
constexpr std::size_t kMostCandidates = 8;

// Two poses within these (m, m, rad) are one candidate. Chosen: the starting poses that views give
// scatter by a metre, storeys are 2.5 m apart and more.
constexpr double kSameDistance = 4.0;
constexpr double kSameHeight = 1.5;
constexpr double kSameHeading = 0.5;
// Weight of heights among distances. Chosen: another storey shows other surroundings.
constexpr double kHeightWeight = kSameDistance / kSameHeight;

}  // namespace

bool is_same_place(const Pose& a, const Pose& b) {
  const Pose between = a.inverse() * b;
  return between.translation.norm() < kSameDistance &&
         std::abs(between.translation.z()) < kSameHeight &&
         rotation_angle(between.rotation) < kSameHeading;
}

PlaceSearch::PlaceSearch(const loop_closing::LoopClosingConfig& verification, CloudSource& clouds,
                         const std::vector<KeyFrame>& key_frames, std::vector<Pose> places,
                         const Eigen::Vector3d& p_base_lidar,
                         const std::filesystem::path& directory)
    : verification_(verification),
      places_(std::move(places)),
      appearances_(directory),
      verifier_(verification, clouds, key_frames, p_base_lidar) {}

void PlaceSearch::append(const loop_closing::PreparedKeyFrame& prepared) {
  if (prepared.points) verifier_.add_view(appended_, *prepared.points);
  appearances_.append(prepared.appearance);
  ++appended_;
}

/// Where the view from above agrees best at one of the two headings that the descriptors allow. Its
/// score is 0 if one of the views is empty, for then there is no such pose.
PlaceSearch::Start PlaceSearch::start_at(std::size_t place, const Appearance& appearance,
                                         const std::vector<Eigen::Vector2f>& cells) const {
  const Appearance older = *appearances_[place];
  const ViewCorrelator correlator(older.view);
  Start best;
  for (const double heading : headings_by_views(older, appearance)) {
    const ViewMatch match = correlator.match(cells, heading);
    if (match.score <= best.score) continue;
    best = {places_[place] * planar_pose(match.translation, heading), match.score};
  }
  return best;
}

std::vector<Pose> PlaceSearch::candidates(const loop_closing::Points& points) const {
  const Appearance appearance = loop_closing::appearance_of(points);
  const std::vector<Eigen::Vector2f> cells = appearance.view.cells();
  std::vector<Start> starts;
  for (const std::size_t place : appearances_.similar_to(appearance, kNearest, kSimilar)) {
    const Start start = start_at(place, appearance, cells);
    if (start.score > 0.0) starts.push_back(start);
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.score > b.score; });
  std::vector<Pose> poses;
  for (const Start& start : starts) {
    const bool is_known = std::any_of(poses.begin(), poses.end(), [&](const Pose& pose) {
      return is_same_place(pose, start.T_map_base);
    });
    if (!is_known && poses.size() < kMostCandidates) poses.push_back(start.T_map_base);
  }
  return poses;
}

std::vector<Pose> PlaceSearch::candidates_near(const Pose& claimed,
                                               const loop_closing::Points& points) const {
  std::vector<Pose> poses;
  add_candidates_at(claimed, points, poses);
  const Pose lifted = at_height_of_map(claimed);
  if (!is_same_place(claimed, lifted)) add_candidates_at(lifted, points, poses);
  return poses;
}

void PlaceSearch::add_candidates_at(const Pose& claimed, const loop_closing::Points& points,
                                    std::vector<Pose>& poses) const {
  poses.push_back(claimed);
  const std::size_t place = nearest_place(claimed, kHeightWeight);
  const auto older = appearances_[place];
  if (!older) return;
  const double heading = yaw_of(places_[place].rotation.conjugate() * claimed.rotation);
  const ViewMatch match =
      ViewCorrelator(older->view).match(loop_closing::appearance_of(points).view.cells(), heading);
  poses.push_back(places_[place] * planar_pose(match.translation, heading));
}

/// The pose at the height of the place that is nearest as seen from above.
Pose PlaceSearch::at_height_of_map(const Pose& T_map_base) const {
  Pose lifted = T_map_base;
  lifted.translation.z() = places_[nearest_place(T_map_base, 0.0)].translation.z();
  return lifted;
}

std::size_t PlaceSearch::nearest_place(const Pose& T_map_base, double height_weight) const {
  const Eigen::Vector3d weights(1.0, 1.0, height_weight);
  const auto distance = [&](const Pose& place) {
    return (place.translation - T_map_base.translation).cwiseProduct(weights).squaredNorm();
  };
  const auto nearest =
      std::min_element(places_.begin(), places_.end(),
                       [&](const Pose& a, const Pose& b) { return distance(a) < distance(b); });
  return static_cast<std::size_t>(nearest - places_.begin());
}

std::optional<PoseEstimate> PlaceSearch::verified(const Pose& T_map_base_guess) {
  const std::size_t place = nearest_place(T_map_base_guess, kHeightWeight);
  const auto match = verifier_.match(place, places_[place].inverse() * T_map_base_guess);
  if (!match) return std::nullopt;
  return PoseEstimate{places_[place] * match->T_place_scan, match->covariance};
}

}  // namespace lidar_mapping::localization
