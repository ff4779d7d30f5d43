// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "motion_filter.hpp"
#include "vertical_structure_map.hpp"

namespace lidar_mapping::front_end {

/// Finds out that a sensor moves although its rings on the ground look as if it stood still: by
/// upright points, which stay behind. Then follows it by these until the map is no longer that of
/// one place.
class FalseStandstillRecovery {
 public:
  /// The map is given up.
  void reset();
  /// These points went into the map.
  void insert(const SampledPoints& points, const MotionState& state);

  /// Where a motion was found, puts `filter` to where the upright points are, and returns true:
  /// what else there is in the scan may be asked from there. `agile` is `filter` predicted to this
  /// scan with the largest accelerations.
  bool track(const SampledPoints& points, const MotionFilter& high_noise_filter,
             MotionFilter& filter);

  /// To be called for each scan that was not followed, `seconds` after the last one. If the sensor
  /// turns out to be elsewhere than where it was matched, `filter` is put there, and true returned.
  /// `one_place` is MapInitialization::is_one_place().
  bool detect(const SampledPoints& points, const registration::NdtMatch& match, double seconds,
              bool single_place, MotionFilter& filter);

 private:
  struct Inserted {
    SampledPoints points;
    MotionState state;
  };
  /// Where a scan seems to be.
  struct Hypothesis {
    Pose pose;
    double seconds = 0.0;    ///< since the one before
    int evidence_there = 0;  ///< evidence for it
    int evidence_here = 0;   ///< and for the pose that was matched
  };

  void insert_pending();
  void finish();
  std::optional<MotionState> find_motion(const SampledPoints& points, const MotionState& matched);
  std::optional<Hypothesis> find_other_pose(const std::vector<Eigen::Vector3f>& points,
                                            const Pose& matched);
  const Pose& last_pose() const;
  Pose coarse_search(const std::vector<Eigen::Vector3f>& points) const;
  void confirm(const Pose& pose);
  bool is_consistent() const;
  std::optional<Pose> fit(const SampledPoints& points, const MotionState& predicted);
  /// True if the points fit there, and less well before and behind on the way, whose direction is
  /// `ahead` in the sensor's axes.
  bool is_distinct(const VerticalStructureMap::Fit& fit, const Eigen::Vector2d& ahead,
                   const std::vector<Eigen::Vector3f>& points) const;

  std::vector<Inserted> pending_;  ///< not yet in the map: it is seldom needed
  VerticalStructureMap map_;
  int inserted_scans_ = 0;          ///< put into it
  std::optional<Pose> first_pose_;  ///< where the map began
  Pose confirmed_pose_;             ///< the last pose with upright points where they were
  std::vector<Hypothesis> hypotheses_;
  double since_hypothesis_ = 0.0;  ///< s
  bool recovering_ = false;
  int failed_fits_ = 0;
  bool finished_ = false;
};

}  // namespace lidar_mapping::front_end
