#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/front_end/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// The motion during a sweep as other sensors followed it: poses of base_link at equal steps of
/// time, seen from where it was at the reference time.
struct FollowedMotion {
  double begin = 0.0;  ///< of the first one, s after the reference time
  double step = 0.0;   ///< s between two
  std::vector<Pose> T_reference_base;
  /// Where the points were moved to when they were made to look as if base_link turned at a
  /// constant rate: T_seen_moved of the same instants. Empty where they are as they were seen.
  std::vector<Eigen::Quaterniond> R_seen_moved;

  Pose at(double time) const;
};

/// A sweep whose points are to be bent: matcher and map move a point p seen s seconds after the
/// reference time to place(twist, s) p, with a twist that is constant (deskew.hpp). Bent points lie
/// where that leads to what the followed motion says, if the twist is the one given here; and a
/// correction of the twist that the match finds is one of the followed motion.
class InertialSweep {
 public:
  InertialSweep() = default;
  /// `reference` is that of the match, s after the scan's stamp.
  InertialSweep(const FollowedMotion& motion, const Vector6d& twist, double reference);

  void bend(SampledPoints& points) const;
  /// The twist that the match found.
  void set_matched(const Vector6d& twist) { matched_ = twist; }
  /// Pose of base_link at the scan's stamp, seen from where it was at the reference time.
  Pose T_reference_stamp() const;
  /// The scan's points as they would have been seen at the stamp; times are those after the stamp.
  PointCloud deskewed(PointCloud cloud, int threads) const;

 private:
  using Matrix34 = Eigen::Matrix<float, 3, 4>;

  /// Each point by the matrix of its instant, which is linear between those of the steps.
  Matrix34 at(const std::vector<Matrix34>& steps, float time) const;

  double begin_ = 0.0;
  double step_ = 1.0;
  double reference_ = 0.0;
  Vector6d twist_ = Vector6d::Zero();
  Vector6d matched_ = Vector6d::Zero();
  Pose T_reference_stamp_;
  std::vector<Matrix34> bent_;
};

}  // namespace lidar_mapping::front_end
