// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "hypothesis.hpp"

namespace lidar_mapping::localization {

/// All places that are possible, none of them twice.
class Hypotheses {
 public:
  void clear() { all_.clear(); }
  std::size_t size() const { return all_.size(); }
  /// The most likely one; null if there is none.
  const Hypothesis* best() const;
  /// Probability that the most likely one is right: its odds among those of all and of none.
  double probability() const;

  void move(const Pose& T_previous_base, const Covariance6& covariance);
  /// Matches a scan at each, and drops those that it refutes.
  void update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher, double way);
  /// A verification led to this pose: a new hypothesis, or one more sign for one that is there.
  void verify(const PoseEstimate& verified);
  /// Keeps those within `distance` (m) of a pose, seen from above; none if none is.
  void keep_near(const Pose& T_map_base, double distance);
  const std::vector<Hypothesis>& all() const { return all_; }

 private:
  void merge();

  std::vector<Hypothesis> all_;
};

}  // namespace lidar_mapping::localization
