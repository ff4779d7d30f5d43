// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/localization/map_index.hpp"

namespace lidar_mapping::localization {

/// A scan of a drive, and how odometry moved to it.
struct LocalizerInput {
  Scan scan;             ///< in base_link, deskewed to the stamp
  Pose T_previous_base;  ///< motion since the previous scan by odometry; ignored for the first
  /// Of that motion, in the axes of base_link at this scan.
  Covariance6 covariance = Covariance6::Identity();
  /// False if odometry does not lead here from the previous scan.
  bool is_connected = true;
  /// Position of the LiDAR in base_link, m.
  Eigen::Vector3d p_base_lidar = Eigen::Vector3d::Zero();
};

/// What is claimed about the place of a scan.
enum class LocalizationState {
  kSearching,  ///< the place has not been found yet: no pose
  kFollowing,  ///< the scan agrees with the map at the pose
  kBesideMap,  ///< what is seen is not in the map, or has changed: the pose is that of odometry
  kLost        ///< the place was given up and is searched for again: no pose
};
/// "searching", "following", "beside_map", "lost".
const char* to_string(LocalizationState state);
/// True if the state comes with a pose.
bool has_pose(LocalizationState state);

/// The place of a scan.
struct LocalizationResult {
  Stamp stamp = 0;                                          ///< of the scan
  LocalizationState state = LocalizationState::kSearching;  ///< the claim in one word
  std::string reason;                                       ///< one sentence about the state
  Pose T_map_base;                                          ///< if the state has a pose
  /// Of T_map_base, in the axes of base_link.
  Covariance6 covariance = Covariance6::Identity();
  /// Probability, 0 to 1, that the place is the right one; of the best hypothesis while searching.
  double probability = 0.0;
  /// Mean robust weight of the points above ground, 0 to 1; those that the map does not know have
  /// none.
  double agreement = 0.0;
  double coverage = 0.0;       ///< fraction of the points in voxels that the map knows, 0 to 1
  std::size_t hypotheses = 0;  ///< number of places that are possible
};

/// Agreement of a point in a voxel of which the map knows no surface. Chosen: no weight is
/// negative.
constexpr float kNotInMap = -1.0F;

/// A point of a scan that was matched with the map.
struct MatchedPoint {
  Eigen::Vector3f p_base = Eigen::Vector3f::Zero();  ///< m
  float agreement = kNotInMap;                       ///< its robust weight, 0 to 1, or kNotInMap
};

/// Finds a vehicle in a finished map without an initial pose, and follows it there, scan by scan
/// (doc/localization.md). Uses no clock and no files of its own. One thread at a time uses it.
class Localizer {
 public:
  /// `map` must outlive this object.
  explicit Localizer(MapIndex& map);
  ~Localizer();

  /// A pose of the next scan as a person claims it, right to some metres. It is examined as any
  /// other candidate, so a wrong one does no harm.
  void set_initial_pose(const Pose& T_map_base);
  /// Gives the place up and searches in the whole map, for instance because a person sees that it
  /// is wrong.
  void restart();
  /// Throws InputError if the stamp does not increase, and FileError if a part of the map cannot be
  /// read from the temporary file of MapIndex or put there; the next scan may be given all the
  /// same.
  LocalizationResult process(const LocalizerInput& input);
  /// The points of the newest scan that were matched, and how well they fit to the map at the pose
  /// of its result; none without a pose. They cost time only when they are asked for: about as much
  /// as an iteration of the match. Throws FileError as process() does.
  std::vector<MatchedPoint> matched_points();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::localization
