// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "matching/ndt_types.hpp"
#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// The angle by which the points have to be rotated upwards, with its standard deviation, rad.
struct ElevationEstimate {
  double angle = 0.0;
  double sigma = 0.0;
};

/// Weighted mean of estimates.
class ElevationMean {
 public:
  void add(const ElevationEstimate& estimate);
  int count() const { return count_; }
  /// The mean. Its sigma is the larger one of two values: the sigma that follows from those of the
  /// estimates, and the sigma that follows from their scatter.
  ElevationEstimate value() const;
  /// The sigma of a typical estimate (harmonic mean of the variances); there must be at least one
  /// estimate.
  double typical_sigma() const;

 private:
  int count_ = 0;
  // Sums of w, w x, w^2, w^2 x and w^2 x^2.
  double w_ = 0.0, wx_ = 0.0, ww_ = 0.0, wwx_ = 0.0, wwxx_ = 0.0;
};

/// Detects whether a LiDAR reports all elevation angles too low or too high by the same angle. Such
/// a sensor sees the ground as a cone around itself. Two views of the same ground from different
/// positions then do not fit together, whatever the relative pose. Scans of the drive are compared
/// in pairs, and the angle is accepted when it is large enough and significant
/// (doc/front_end_scans.md). Elevation is measured from the LiDAR's plane z = 0.
class ElevationCalibration {
 public:
  ElevationCalibration();

  /// Adds a scan that was inserted into the map: its points, rotated upwards by applied_angle(),
  /// and the state with which they were inserted. `voxel_size` is the voxel size of the map, m.
  void add_scan(const SampledPoints& points, const MotionState& state, double voxel_size);
  /// Compares the scan that was added last. This costs more than all other work for a scan, so call
  /// it at a scan with little other work. add_scan() calls it if it was not called before.
  void compare_pending();
  /// The next scan is not connected with the previous one.
  void interrupt();

  /// The accepted error of the sensor's elevation angles, rad; 0 until an angle is accepted.
  double accepted_angle() const { return accepted_angle_; }
  /// The angle by which points have to be rotated upwards now, rad. It follows accepted_angle() in
  /// steps, so that no scan differs much from the map that it is matched with.
  double applied_angle() const { return applied_angle_; }
  /// The current estimate, significant or not. Its sigma is larger than the scatter of the pairs,
  /// because the pairs of one place have common errors.
  ElevationEstimate estimate() const;

 private:
  struct Frame {
    SampledPoints points;  ///< as measured, deskewed to one instant
    Pose T_map_sensor;
    double voxel_size;
  };

  bool is_converged() const;
  double frame_distance() const;
  void compare(const Frame& a, const Frame& b);
  void decide();

  std::deque<Frame> frames_;
  bool comparison_pending_ = false;  ///< the last frame has not been compared yet
  GaussianVoxelMap map_;
  ElevationMean mean_;
  double accepted_angle_ = 0.0;
  double applied_angle_ = 0.0;
};

}  // namespace lidar_mapping::front_end
