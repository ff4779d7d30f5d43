// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::pipeline {

/// Why the pose of a scan is not as good as usual, from the least to the most.
enum class Doubt {
  kDoubtful,    ///< fitted, but the step may be off by more than 0.3 m or 1 degree
  kDegraded,    ///< fitted poorly, or was probably wrong: used, and kept out of the local map
  kRepeated,    ///< the points of the scan before came again: the pose is a guess
  kDegenerate,  ///< the points left a direction open
  kLost         ///< did not fit: the pose is a guess
};
/// "doubtful", "degraded", "repeated", "degenerate", "lost".
const char* to_string(Doubt doubt);
/// Of a state as front end and session name it; none of "tracking".
std::optional<Doubt> doubt_of_state(const std::string& state);

/// What the front end said of one scan.
struct TrackedStep {
  Stamp stamp = 0;
  std::optional<Doubt> doubt;
  Eigen::Vector3d p_odom_base = Eigen::Vector3d::Zero();
  double unobserved_stddev = 0.0;  ///< FrontEndStatus::unobserved_stddev
  double probability = -1.0;       ///< that the step is right; negative: not known
};

/// A part of the drive whose scans are doubtful for the same reason.
struct DoubtfulStretch {
  Doubt doubt = Doubt::kLost;
  Stamp begin = 0;  ///< of the first scan
  Stamp end = 0;    ///< of the last scan
  std::size_t scans = 0;
  double way_begin = 0.0;  ///< m from the beginning of the drive, as odometry has it
  double way = 0.0;        ///< m, with the step that leads into it
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< where it begins
  /// Standard deviation, m: over it from directions that nothing observed (TrackingSummary), or of
  /// its end by all that is known of the map (drive_doubt()); infinite where nobody knows.
  double expected_error = 0.0;
  double lowest_probability = -1.0;  ///< that a step is right, of all that say so; else negative
  bool is_trusted = true;            ///< false: the map is not to be relied on here
};

/// Gathers doubtful scans to stretches. Those of one kind that are at most a second apart count as
/// one: what a person would look at, and not each scan.
class TrackingSummary {
 public:
  /// Stamps increase.
  void add(const TrackedStep& step);

  /// In the order in which they begin.
  const std::vector<DoubtfulStretch>& stretches() const { return stretches_; }
  std::size_t scans() const { return scans_; }
  double way() const { return way_; }  ///< of the whole drive, m

 private:
  void go_on_to(const TrackedStep& step);
  DoubtfulStretch& stretch_for(Doubt doubt, const TrackedStep& step);

  std::vector<DoubtfulStretch> stretches_;
  std::vector<double> variances_before_;  ///< of the unobserved way, before each stretch
  double variance_ = 0.0;                 ///< of the unobserved way so far, m^2
  double variance_before_ = 0.0;          ///< up to the scan before
  std::optional<TrackedStep> last_;
  std::size_t scans_ = 0;
  double way_ = 0.0;
  double way_before_ = 0.0;  ///< up to the scan before
};

/// The error that a map is allowed to have over a stretch of this length, both in m: 1 % of the
/// way and at least half a metre, as map_quality allows odometry.
double allowed_error(double way);

}  // namespace lidar_mapping::pipeline
