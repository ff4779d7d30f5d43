// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "delayed_initialization.hpp"
#include "local_map.hpp"
#include "step_belief.hpp"
#include "sweep_matcher.hpp"
#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// The beginning of a local map. The points of its first scan are kept until the motion during that
/// scan is known; where few rings make a poor map of it, the first scans are looked at again
/// (DelayedInitialization). Tells how much of the map there is.
class MapInitialization {
 public:
  explicit MapInitialization(registration::NeighborSearch neighbors) : delayed_(neighbors) {}

  /// The map is given up.
  void reset();
  /// A map begins with a scan whose pose at its stamp is known.
  void start(const Pose& T_odom_base);
  /// The points of that scan and those between its rings, times counted from `reference` (s after
  /// the stamp); skewed if they have times.
  void set_first_scan(const SampledPoints& points, const SampledPoints& between_rings,
                      bool have_times, double reference);

  /// False until a second scan was matched.
  bool motion_known() const { return motion_known_; }
  /// Matches the second scan, whose reference time is `seconds` after that of the first one: the
  /// speed may be anything, and the first scan is still as skewed as it came. Leaves it in the map
  /// as deskewed as it can be.
  SweepMatcher::Found match_second_scan(const registration::NdtPoints& points,
                                        const registration::MotionBelief& prediction,
                                        double seconds, SweepMatcher& matcher, LocalMap& map) const;
  /// Whether the map is to begin again with the second scan, given the belief in its match. A first
  /// scan from elsewhere fits somewhere too, and its points would bend the map that grows from it.
  /// At most once per map: where points are few, no second scan is ever matched with certainty.
  bool replaces_first_scan(const StepBelief& belief);
  /// That match was accepted.
  void set_motion(const registration::NdtMatch& match);

  /// The points of the first scan, and where they were seen if it moved with this twist.
  const SampledPoints& first_points() const { return first_points_; }
  MotionState first_state(const Vector6d& twist) const {
    return {moved(start_pose_, twist, first_reference_), twist};
  }

  /// True as long as scans may be looked at again.
  bool is_provisional() const { return delayed_.is_active(); }
  /// What is provisional stays as it is.
  void finalize() { delayed_.stop(); }
  void add(MatchedScan scan) { delayed_.add(std::move(scan)); }
  /// To be called after each matched scan; see DelayedInitialization::look_again().
  std::vector<Revision> rematch_first_scans(const MotionFilter& filter, const MatchJudge& judge,
                                            LocalMap& map);

  /// The scan that was added last went into the map, which has voxels of this edge (m).
  void set_inserted(const SampledPoints& points, const Eigen::Vector3d& p_odom, double voxel_size);
  int inserted_scans() const { return inserted_scans_; }
  /// True while the map is that of few scans: see initial_drift_variance_factor().
  bool has_few_scans() const;
  /// True while all of the map was made from about one place.
  bool covers_single_place() const { return single_place_; }

 private:
  DelayedInitialization delayed_;
  Pose start_pose_;  ///< of the first scan, at its stamp
  SampledPoints first_points_;
  SampledPoints first_points_between_rings_;
  bool first_has_times_ = false;
  double first_reference_ = 0.0;
  int inserted_scans_ = 0;
  bool single_place_ = true;
  bool motion_known_ = false;
  bool first_scan_replaced_ = false;  ///< to the scan that the map begins with now
};

}  // namespace lidar_mapping::front_end
