// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "lidar_mapping/common/pose.hpp"

#include "local_frame.hpp"

namespace lidar_mapping::preprocessing {

/// Refuses fixes that contradict the measured motion. The way of the antenna by dead reckoning is
/// laid over the last good fixes (a turn about the vertical and a shift, least squares); a fix has
/// to lie where the way goes on, within three standard deviations of both plus the drift since the
/// last good fix. So a jump is refused when it begins, while it lasts, and the return is taken.
/// What no vehicle can drive is refused always, and without measured motion only that.
class GnssGate {
 public:
  /// `motion` is T_previous_now of base_link since the fix before, whatever became of that one;
  /// nothing if it was not measured. Returns what is wrong, or an empty text for a good fix.
  std::string check(const LocalFix& fix, const Eigen::Vector3d& p_base_antenna,
                    const std::optional<Pose>& motion);
  void clear();

  /// base_link by dead reckoning, level, at the last fix; nothing if that motion was not measured.
  std::optional<Pose> dead_reckoning() const;

 private:
  struct Match {
    Eigen::Vector3d p_dr = Eigen::Vector3d::Zero();   ///< antenna by dead reckoning
    Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();  ///< antenna by GNSS
    double sigma = 0.0;                               ///< m, horizontal
    double path_length = 0.0;                         ///< m, driven until then
  };
  struct Alignment {
    Eigen::Matrix2d R_enu_dr;
    Eigen::Vector2d center_dr;
    Eigen::Vector2d center_enu;
  };

  void dead_reckon(const Eigen::Vector3d& p_base_antenna, const std::optional<Pose>& motion);
  std::optional<Alignment> alignment() const;
  std::string problem_with(const LocalFix& fix, const Eigen::Vector3d& p_dr) const;
  void add_match(const LocalFix& fix, const Eigen::Vector3d& p_dr);

  Pose T_dr_base_;  ///< level: errors of the gyro's horizontal axes do not add up
  double path_length_ = 0.0;
  bool has_motion_ = false;
  std::optional<LocalFix> last_good_;
  Match last_match_;           ///< of the last good fix
  std::deque<Match> matches_;  ///< spread along the way
};

}  // namespace lidar_mapping::preprocessing
