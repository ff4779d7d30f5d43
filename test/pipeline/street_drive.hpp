// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/map_extension.hpp"

namespace lidar_mapping::pipeline::test {

/// m between two key frames of these drives. No limit of the plan is a multiple of it, so that
/// rounding decides nothing.
inline constexpr double kStreetStep = 2.1;
/// Stamps of the first key frame of the map and of a later drive, ns.
inline constexpr Stamp kMapBegin = from_seconds(1e9);
inline constexpr Stamp kDriveBegin = from_seconds(1e9 + 86'400.0);

/// A pose on a street along x.
inline Pose on_street(double x, double y = 0.0) {
  Pose pose;
  pose.translation = {x, y, 0.0};
  return pose;
}

/// The frame of odometry of the later drive.
inline Pose T_odom_map() {
  Pose pose = on_street(5.0, -3.0);
  pose.rotation = exp_so3({0.0, 0.0, 1.2});
  return pose;
}

inline Stamp stamp_after(Stamp begin, std::size_t key_frames) {
  return begin + static_cast<Stamp>(key_frames) * from_seconds(0.2);
}

/// Position along the street, m, after so many steps from the beginning of the map.
inline double street_length(int steps) { return steps * kStreetStep; }

/// Poses of a map from x = 0 on, with the numbers 0, 1, ...
inline KeyFramePoses street_map(std::size_t key_frames = 51) {
  KeyFramePoses map;
  map.revision = 1;
  for (std::size_t i = 0; i < key_frames; ++i) {
    const Pose T_map_base = on_street(street_length(static_cast<int>(i)));
    map.poses.push_back({static_cast<KeyFrameIndex>(i), stamp_after(kMapBegin, i), T_map_base});
  }
  return map;
}

/// What is claimed about a place, by one letter: f followed, p followed where the map knows half of
/// the surroundings, b beside the map, u beside the map until a verification confirms it, s
/// searched for, l lost.
inline localization::LocalizationResult place_of(char letter, const Pose& T_map_base) {
  using localization::LocalizationState;
  localization::LocalizationResult place;
  place.covariance = diagonal_covariance(0.02, 0.001);
  if (letter == 's' || letter == 'l') {
    place.state = letter == 's' ? LocalizationState::kSearching : LocalizationState::kLost;
    return place;
  }
  const bool is_followed = letter == 'f' || letter == 'p';
  place.state = is_followed ? LocalizationState::kFollowing : LocalizationState::kBesideMap;
  place.T_map_base = T_map_base;
  place.agreement = letter == 'b' ? 0.1 : 0.8;
  place.coverage = letter == 'b' ? 0.2 : letter == 'p' ? 0.5 : 0.9;
  return place;
}

/// A drive one metre beside the way of the map, with a key frame for each letter. It begins so many
/// steps after the beginning of the map.
inline std::vector<LocalizedKeyFrame> street_drive(const std::string& letters, int begin,
                                                   std::uint32_t segment = 0,
                                                   std::size_t first_index = 0) {
  std::vector<LocalizedKeyFrame> drive;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    const Pose T_map_base = on_street(street_length(begin + static_cast<int>(i)), 1.0);
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(first_index + i);
    key_frame.segment = segment;
    key_frame.stamp = stamp_after(kDriveBegin, first_index + i);
    key_frame.T_odom_base = T_odom_map() * T_map_base;
    key_frame.motion_covariance = diagonal_covariance(0.01, 0.001);
    drive.push_back({key_frame, place_of(letters[i], T_map_base)});
    drive.back().place.stamp = key_frame.stamp;
  }
  return drive;
}

/// So many times the same letter.
inline std::string times(std::size_t count, char letter) { return std::string(count, letter); }

}  // namespace lidar_mapping::pipeline::test
