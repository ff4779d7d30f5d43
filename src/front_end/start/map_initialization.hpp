// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "judgement/step_belief.hpp"
#include "local_map/local_map.hpp"
#include "matching/sweep_matcher.hpp"
#include "scan/sweep_sampler.hpp"
#include "start/delayed_initialization.hpp"
#include "tracking/tracker.hpp"

namespace lidar_mapping::front_end {

/// Initialisation of a local map. The points of the first scan are stored until the motion during
/// that scan is known. If the map of the first scans is poor because the sensor has few rings,
/// these scans are matched again later (DelayedInitialization).
class MapInitialization {
 public:
  explicit MapInitialization(NeighborSearch neighbors) : delayed_(neighbors) {}

  /// Starts a map with a scan whose pose at its stamp is known.
  void start(const Pose& T_odom_base);
  /// Stores the points of the first scan and those interpolated between its rings. The times are
  /// relative to `reference` (s after the stamp); points with times are still distorted by the
  /// motion.
  void set_first_scan(const SampledPoints& points, const SampledPoints& between_rings,
                      bool have_times, double reference);

  /// Matches the second scan, whose reference time is `seconds` after that of the first one. The
  /// speed may have any value, and the first scan is still distorted by the motion. Afterwards the
  /// map holds the first scan, deskewed with the motion that was found.
  SweepMatcher::Found match_second_scan(const NdtPoints& points, const MotionBelief& prediction,
                                        double seconds, SweepMatcher& matcher, LocalMap& map) const;
  /// Decides whether the map has to be started again with the second scan, given the belief in its
  /// match, which is not accepted yet. A first scan from a different place would also find a match
  /// somewhere, and its points would bend the map. It returns true at most once per map: if a scan
  /// has few points, no second scan can be matched with certainty.
  bool replaces_first_scan(const StepBelief& belief);
  /// To be called when that match was accepted.
  void set_motion(const NdtMatch& match);

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
  /// To be called for each matched scan before it is inserted: stores it as long as it may be
  /// matched again.
  void add(Stamp stamp, const SweepSampler& sweep, const MotionFilter& filter);
  /// To be called after each matched scan; see DelayedInitialization::rematch().
  std::vector<Revision> rematch_first_scans(const MotionFilter& filter, const MatchJudge& judge,
                                            LocalMap& map);

  /// To be called when these points of the scan added last were inserted into the map.
  void set_inserted(const SampledPoints& points) { delayed_.set_inserted(points); }

 private:
  DelayedInitialization delayed_;
  Pose start_pose_;  ///< pose of the first scan at its stamp
  SampledPoints first_points_;
  SampledPoints first_points_between_rings_;
  bool first_has_times_ = false;
  double first_reference_ = 0.0;
  bool first_scan_replaced_ = false;  ///< by the scan with which the map begins now
};

}  // namespace lidar_mapping::front_end
