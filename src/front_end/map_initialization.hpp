// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "delayed_initialization.hpp"
#include "local_map.hpp"
#include "step_belief.hpp"
#include "sweep_matcher.hpp"
#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// Initialisation of a local map. The points of the first scan are stored until the motion during
/// that scan is known. If the map of the first scans is poor because the sensor has few rings,
/// these scans are matched again later (DelayedInitialization). The class also tells how complete
/// the map is.
class MapInitialization {
 public:
  explicit MapInitialization(registration::NeighborSearch neighbors) : delayed_(neighbors) {}

  /// To be called when the map is discarded.
  void reset();
  /// Starts a map with a scan whose pose at its stamp is known.
  void start(const Pose& T_odom_base);
  /// Stores the points of the first scan and those interpolated between its rings. The times are
  /// relative to `reference` (s after the stamp); points with times are still distorted by the
  /// motion.
  void set_first_scan(const SampledPoints& points, const SampledPoints& between_rings,
                      bool have_times, double reference);

  /// False until the second scan was matched.
  bool motion_known() const { return motion_known_; }
  /// Matches the second scan, whose reference time is `seconds` after that of the first one. The
  /// speed may have any value, and the first scan is still distorted by the motion. Afterwards the
  /// map holds the first scan, deskewed with the motion that was found.
  SweepMatcher::Found match_second_scan(const registration::NdtPoints& points,
                                        const registration::MotionBelief& prediction,
                                        double seconds, SweepMatcher& matcher, LocalMap& map) const;
  /// Decides whether the map has to be started again with the second scan, given the belief in its
  /// match. A first scan from a different place would also find a match somewhere, and its points
  /// would bend the map. It returns true at most once per map: if a scan has few points, no second
  /// scan can be matched with certainty.
  bool replaces_first_scan(const StepBelief& belief);
  /// To be called when that match was accepted.
  void set_motion(const registration::NdtMatch& match);

  /// The points of the first scan, and the state at which they were measured if it moved with this
  /// twist.
  const SampledPoints& first_points() const { return first_points_; }
  MotionState first_state(const Vector6d& twist) const {
    return {moved(start_pose_, twist, first_reference_), twist};
  }

  /// True as long as scans may be matched again.
  bool is_provisional() const { return delayed_.is_active(); }
  /// Makes the provisional scans final as they are.
  void finalize() { delayed_.stop(); }
  void add(MatchedScan scan) { delayed_.add(std::move(scan)); }
  /// To be called after each matched scan; see DelayedInitialization::rematch().
  std::vector<Revision> rematch_first_scans(const MotionFilter& filter, const MatchJudge& judge,
                                            LocalMap& map);

  /// To be called when the scan added last was inserted into the map, which has voxels of this edge
  /// length (m).
  void set_inserted(const SampledPoints& points, const Eigen::Vector3d& p_odom, double voxel_size);
  int inserted_scans() const { return inserted_scans_; }
  /// True while the map consists of few scans: see initial_drift_variance_factor().
  bool has_few_scans() const;
  /// True while all scans of the map were taken at about the same place.
  bool covers_single_place() const { return single_place_; }

 private:
  DelayedInitialization delayed_;
  Pose start_pose_;  ///< pose of the first scan at its stamp
  SampledPoints first_points_;
  SampledPoints first_points_between_rings_;
  bool first_has_times_ = false;
  double first_reference_ = 0.0;
  int inserted_scans_ = 0;
  bool single_place_ = true;
  bool motion_known_ = false;
  bool first_scan_replaced_ = false;  ///< by the scan with which the map begins now
};

}  // namespace lidar_mapping::front_end
