// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "local_map/vertical_structure_map.hpp"
#include "motion/motion_filter.hpp"

namespace lidar_mapping::front_end {

/// Detects that a sensor moves although the match reports a standstill: the rings of the sensor on
/// the ground look the same at every place. Points on vertical structures show the motion, because
/// they stay behind. The sensor is then tracked with these points until the map covers more than a
/// single place.
class FalseStandstillRecovery {
 public:
  /// To be called when the map is discarded.
  void reset();
  /// To be called when these points were inserted into the map.
  void insert(const SampledPoints& points, const MotionState& state);

  /// If a motion was detected, returns the filter with the pose that the vertical structures give;
  /// the remaining directions can then be matched from there. `high_noise_filter` is the filter
  /// predicted to this scan with the largest accelerations, `predicted` the pose of the usual
  /// prediction.
  std::optional<MotionFilter> track(const SampledPoints& points,
                                    const MotionFilter& high_noise_filter, const Pose& predicted);

  /// To be called for each scan for which track() returned nothing, `seconds` after the previous
  /// one. If the sensor turns out to be at another pose than the matched one, returns the predicted
  /// filter, restarted at that pose. `single_place` is MapCoverage::is_single_place.
  std::optional<MotionFilter> detect(const SampledPoints& points, const NdtMatch& match,
                                     double seconds, bool single_place, const MotionFilter& filter);

 private:
  struct Inserted {
    SampledPoints points;
    MotionState state;
  };
  /// A possible pose of a scan.
  struct Hypothesis {
    Pose pose;
    double seconds = 0.0;    ///< since the previous hypothesis
    int evidence_there = 0;  ///< evidence for this pose
    int evidence_here = 0;   ///< evidence for the matched pose
  };

  void insert_pending();
  void finish();
  std::optional<MotionState> find_motion(const SampledPoints& points, const MotionState& matched);
  std::optional<Hypothesis> find_other_pose(const std::vector<Eigen::Vector3f>& points,
                                            const Pose& matched);
  const Pose& last_pose() const;
  void confirm(const Pose& pose);
  bool is_consistent() const;
  std::optional<Pose> fit(const SampledPoints& points, const MotionState& predicted);

  std::vector<Inserted> pending_;  ///< not yet in the map, which is seldom needed
  VerticalStructureMap map_;
  int inserted_scans_ = 0;          ///< number of scans inserted into the map
  std::optional<Pose> first_pose_;  ///< the pose at which the map began
  Pose confirmed_pose_;  ///< the last pose at which the vertical structures agreed with the match
  std::vector<Hypothesis> hypotheses_;
  double since_hypothesis_ = 0.0;  ///< s
  bool recovering_ = false;
  int failed_fits_ = 0;
  bool finished_ = false;
};

}  // namespace lidar_mapping::front_end
