// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

#include "motion_filter.hpp"
#include "sweep_matcher.hpp"

namespace lidar_mapping::front_end {

/// A scan as it was matched when it came.
struct MatchedScan {
  Stamp stamp = 0;
  double reference = 0.0;  ///< to which times count and at which the state is, s after the stamp
  registration::NdtPoints points;
  registration::MotionState state;
  registration::Matrix12d covariance;
  SampledPoints dense;  ///< what went into the map, if anything
};

/// The first scans of a map that begins in motion. They are matched with a map of one scan or two,
/// of which few rings make planes that lean; so they are kept until the map is a better one, and
/// then matched again from the latest to the first, a few per scan that comes in.
class DelayedInitialization {
 public:
  explicit DelayedInitialization(registration::NeighborSearch neighbors) : matcher_(neighbors) {}

  void start();
  void stop();
  bool is_active() const { return active_; }

  /// Nothing is kept unless open, and nothing that comes after the map is a better one.
  void add(MatchedScan scan);
  /// What went into the map of the scan that was added last.
  void set_inserted(const SampledPoints& dense);
  /// What only the second scan tells of the first one.
  void set_first_state(const registration::MotionState& state);

  const std::vector<MatchedScan>& scans() const { return scans_; }
  /// To be called after each scan. Once the map is good enough, or nothing is worth more waiting,
  /// the map becomes that of the later half of the scans; the earlier ones are matched with it and
  /// put into it as they were matched. `filter` knows how the vehicle moves. True when nothing is
  /// left to be done.
  bool rematch(const MotionFilter& filter, const MatchJudge& judge, LocalMap& map);
  /// One result for each of the earlier scans then; none where one of them was lost.
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
  std::optional<MotionFilter> filter_;  ///< goes back through the scans; none before that begins
  std::size_t remaining_ = 0;           ///< so many of the scans are still to be matched again
  std::vector<SweepMatcher::Found> results_;
};

}  // namespace lidar_mapping::front_end
