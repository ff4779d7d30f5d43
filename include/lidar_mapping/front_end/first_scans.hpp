#pragma once

#include <cstddef>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/sweep_matcher.hpp"

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
/// then matched again from the latest to the first.
class FirstScans {
 public:
  void begin();
  void end();
  bool is_open() const { return open_; }

  /// Nothing is kept unless open.
  void add(MatchedScan scan);
  /// What went into the map of the scan that was added last.
  void set_inserted(const SampledPoints& dense);
  /// What only the second scan tells of the first one.
  void set_first(const registration::MotionState& state);

  const std::vector<MatchedScan>& scans() const { return scans_; }
  /// Whether the map is good enough, or nothing is worth more waiting.
  bool is_complete() const;
  /// Matches the earlier scans with a map of the later half of them, and leaves all of them in the
  /// map. `filter` knows how the vehicle moves. One result for each of the earlier scans; none, and
  /// the map as it was, where one of them was lost.
  std::vector<SweepMatcher::Found> match_again(MotionFilter filter, SweepMatcher& matcher,
                                               const MatchJudge& judge, LocalMap& map) const;

 private:
  std::size_t first_of_later_half() const;
  void restore(LocalMap& map) const;

  bool open_ = false;
  std::size_t inserted_ = 0;
  std::vector<MatchedScan> scans_;
};

}  // namespace lidar_mapping::front_end
