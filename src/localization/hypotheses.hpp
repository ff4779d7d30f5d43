// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hypothesis.hpp"

namespace lidar_mapping::localization {

/// All places that are possible, none of them twice. Those that explain the path worse than another
/// one fall behind it; they are kept, so that they do not begin anew whenever they are found again.
class Hypotheses {
 public:
  void clear() { all_.clear(); }
  /// Number of the places that are possible.
  std::size_t size() const;
  /// The most likely one; null if there is none.
  const Hypothesis* best() const;
  /// Probability that the most likely one is right: its odds among those of all and of none.
  double probability() const;

  void move(const Pose& T_previous_base, const Covariance6& covariance);
  /// Matches a scan at each, and drops those that it refutes.
  void update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher, double distance);
  /// A new search begins; its verifications follow.
  void begin_search();
  /// A verification led to this pose: a new hypothesis, or one more sign for one that is there. A
  /// search counts once for each place: several of its candidates may end at the same one.
  void verify(const PoseEstimate& verified);
  /// Keeps those within `distance` (m) of a pose, seen from above; none if none is.
  void keep_near(const Pose& T_map_base, double distance);
  /// Also those that another place has left behind.
  const std::vector<Hypothesis>& all() const { return all_; }

 private:
  void compare(double distance);
  void merge();

  std::vector<Hypothesis> all_;
};

}  // namespace lidar_mapping::localization
