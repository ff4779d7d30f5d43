// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

#include "matching/sweep_matcher.hpp"
#include "motion/motion_filter.hpp"

namespace lidar_mapping::front_end {

/// A scan with the result of its first match.
struct MatchedScan {
  Stamp stamp = 0;
  double reference = 0.0;  ///< reference time of the points and of the state, s after the stamp
  NdtPoints points;
  MotionState state;
  Matrix12d covariance;
  SampledPoints dense;  ///< the points that were inserted into the map, if any
};

/// Second matching of the first scans of a map that begins in motion. These scans are first matched
/// with a map of one or two scans, and with few rings the planes of such a map are tilted. So they
/// are stored until the map is better. Then they are matched again, from the latest to the first, a
/// few per new scan.
class DelayedInitialization {
 public:
  explicit DelayedInitialization(NeighborSearch neighbors) : matcher_(neighbors) {}

  void start();
  void stop();
  bool is_active() const { return active_; }

  /// Stores a scan. Does nothing if inactive, or if the second matching has started.
  void add(MatchedScan scan);
  /// Sets the points of the scan added last that were inserted into the map.
  void set_inserted(const SampledPoints& dense);
  /// Sets the state of the first scan, which is known only after the second scan was matched.
  void set_first_state(const MotionState& state);

  const std::vector<MatchedScan>& scans() const { return scans_; }
  /// To be called after each scan. When enough scans were inserted, or the maximum duration is
  /// over, the map is rebuilt from the later half of the scans. The earlier scans are then matched
  /// with it and inserted at their new poses. `filter` provides the motion model. Returns true when
  /// nothing is left to do.
  bool rematch(const MotionFilter& filter, const MatchJudge& judge, LocalMap& map);
  /// One result for each of the earlier scans; empty if one of them was lost.
  const std::vector<SweepMatcher::Found>& results() const { return results_; }

 private:
  bool is_complete() const;
  std::size_t first_of_later_half() const;
  void start_rematching(const MotionFilter& filter, LocalMap& map);
  bool rematch_scan(std::size_t i, const MatchJudge& judge, LocalMap& map);

  bool active_ = false;
  std::size_t inserted_scans_ = 0;
  std::vector<MatchedScan> scans_;
  SweepMatcher matcher_;
  /// runs backwards through the scans; empty before the second matching starts
  std::optional<MotionFilter> filter_;
  std::size_t remaining_ = 0;  ///< number of scans that still have to be matched again
  std::vector<SweepMatcher::Found> results_;
};

}  // namespace lidar_mapping::front_end
