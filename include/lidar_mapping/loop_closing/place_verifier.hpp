// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// A scan whose place is asked for; all points are thinned, in base_link at its stamp, m.
struct PlaceQuery {
  Points surroundings;  ///< of the scan and of those shortly before it
  Points scan;          ///< of the scan alone, for what it saw through
  /// Position of its LiDAR in base_link, m.
  Eigen::Vector3d p_base_lidar = Eigen::Vector3d::Zero();
};

/// The accepted match of a scan with the surroundings of a key frame: both saw the same, or another
/// place that looks the same.
struct PlaceMatch {
  Pose T_place_scan;  ///< of base_link at the scan in that at the key frame
  /// Of that pose, in the axes of the scan's base_link, with the lower bounds of loops.
  Covariance6 covariance = Covariance6::Identity();
};

/// Tells whether a scan of any drive was taken at a key frame of a finished map, by the matching
/// and the rules of loops (doc/loop_closing.md), without any knowledge of where it was. The class
/// must be called from one thread.
class PlaceVerifier {
 public:
  /// `key_frames` are those of the map, by increasing index. `clouds` must outlive this object.
  /// `p_base_lidar` is the position of the LiDAR that made the map, m.
  PlaceVerifier(const LoopClosingConfig& config, CloudSource& clouds,
                const std::vector<KeyFrame>& key_frames, const Eigen::Vector3d& p_base_lidar);
  ~PlaceVerifier();

  /// Adds what the LiDAR saw at the key frame at this position in `key_frames`; points in its
  /// base_link, m. When all are added, a scan of another LiDAR is compared only where that of the
  /// map can see.
  void add_view(std::size_t place, const Points& points);
  /// The scan that the following calls of match() are about.
  void set_query(const PlaceQuery& query);
  /// Matches that scan with the key frame at this position in `key_frames`, from a starting pose
  /// that should be right to 2 m and 5 degrees. Empty if the match is not accepted, or if the cloud
  /// is not available.
  std::optional<PlaceMatch> match(std::size_t place, const Pose& T_place_scan_guess);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::loop_closing
