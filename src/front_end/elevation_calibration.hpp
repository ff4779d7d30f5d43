// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "lidar_mapping/registration/gaussian_voxel_map.hpp"
#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Angle by which points are to be turned upwards, with its standard deviation, rad.
struct ElevationEstimate {
  double angle = 0.0;
  double sigma = 0.0;
};

/// Weighted mean of estimates.
class ElevationMean {
 public:
  void add(const ElevationEstimate& estimate);
  int count() const { return count_; }
  /// Its sigma is the larger one of what the estimates claim and what their scatter shows.
  ElevationEstimate value() const;
  /// What an estimate claims, in the (harmonic) mean; there must be one.
  double typical_sigma() const;

 private:
  int count_ = 0;
  // Sums of w, w x, w^2, w^2 x and w^2 x^2.
  double w_ = 0.0, wx_ = 0.0, ww_ = 0.0, wwx_ = 0.0, wwxx_ = 0.0;
};

/// Finds out whether a LiDAR reports all elevations too low or too high by the same angle. Such a
/// sensor sees the ground as a cone around itself, and what it sees of it from two places does not
/// fit, wherever the places are taken to be. Scans of the drive are compared in pairs, and an angle
/// is believed when it is large and sure (doc/front_end.md). Elevation counts from the plane
/// z = 0 of base_link.
class ElevationCalibration {
 public:
  ElevationCalibration();

  /// Takes a scan that has gone into the map: its points, turned upwards by applied(), and the
  /// state that they were put there with. `voxel_size` is that of the map, m.
  void add_scan(const SampledPoints& points, const registration::MotionState& state,
                double voxel_size);
  /// Compares the last scan that was taken, which costs more than the rest of a scan together: to
  /// be called on a scan with less to do. see() does it where nobody else has.
  void compare_pending();
  /// The next scan does not hang together with the last one.
  void interrupt();

  /// What the sensor's elevations lack, rad; 0 as long as none is sure.
  double accepted_angle() const { return accepted_angle_; }
  /// Angle by which points are to be turned upwards, rad. It follows found() in steps, so that no
  /// scan differs much from the map that it is matched with.
  double applied_angle() const { return applied_angle_; }
  /// What the pairs say so far, sure or not; sigma is larger than their scatter, as those of one
  /// place err alike.
  ElevationEstimate estimate() const;

 private:
  struct Frame {
    SampledPoints points;  ///< as the sensor gave them, of one instant
    Pose T_map_sensor;
    double voxel_size;
  };

  bool is_converged() const;
  double frame_distance() const;
  void compare(const Frame& a, const Frame& b);
  void decide();

  std::deque<Frame> frames_;
  bool comparison_pending_ = false;  ///< the last frame has not been compared
  registration::GaussianVoxelMap map_;
  ElevationMean mean_;
  double accepted_angle_ = 0.0;
  double applied_angle_ = 0.0;
};

}  // namespace lidar_mapping::front_end
