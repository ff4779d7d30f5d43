// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "lidar_mapping/common/pose.hpp"

#include "gnss/local_frame.hpp"

namespace lidar_mapping::preprocessing {

/// Rejects fixes that contradict the measured motion. The path of the antenna by dead reckoning is
/// aligned with the last good fixes (a rotation about the vertical and a translation, least
/// squares). A fix has to lie on the continuation of this path, within three standard deviations of
/// both plus the drift since the last good fix. So a jump is rejected at its beginning and while it
/// lasts, and fixes are accepted again after it. Motions that no vehicle can make are always
/// rejected; without measured motion, only these are.
class GnssGate {
 public:
  /// `motion` is T_previous_now of base_link since the previous fix, whether that fix was accepted
  /// or not; empty if the motion was not measured. Returns the problem, or an empty text for a good
  /// fix.
  std::string check(const LocalFix& fix, const Eigen::Vector3d& p_base_antenna,
                    const std::optional<Pose>& motion);

  /// The levelled pose of base_link by dead reckoning at the last fix; empty if that motion was not
  /// measured.
  std::optional<Pose> dead_reckoning() const;

 private:
  struct Match {
    Eigen::Vector3d p_dr = Eigen::Vector3d::Zero();   ///< position of the antenna by dead reckoning
    Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();  ///< position of the antenna by GNSS
    double sigma = 0.0;                               ///< m, horizontal
    double path_length = 0.0;                         ///< m, path length up to this fix
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

  Pose T_dr_base_;  ///< kept level, so that errors of the gyro's horizontal axes do not accumulate
  double path_length_ = 0.0;
  bool has_motion_ = false;
  std::optional<LocalFix> last_good_;
  Match last_match_;           ///< of the last good fix
  std::deque<Match> matches_;  ///< distributed along the path
};

}  // namespace lidar_mapping::preprocessing
