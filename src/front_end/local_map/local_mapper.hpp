// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/front_end/step_timer.hpp"

#include "local_map/elevation_calibration.hpp"
#include "local_map/moving_points.hpp"
#include "scan/ring_spacing.hpp"
#include "tracking/tracker_state.hpp"

namespace lidar_mapping::front_end {

/// Builds the local map from tracked scans: decides which scans are inserted, with which points,
/// and into voxels of which size. The inserted scans also show whether the sensor's elevation
/// angles are wrong, and the points are corrected then.
class LocalMapper {
 public:
  explicit LocalMapper(const FrontEndConfig& config)
      : voxel_size_(config.voxel_size), calibrates_elevation_(config.calibrate_elevation) {}

  /// Tells that scans are measured from the origin of their frame, so that the spacing of their
  /// rings can be found.
  void set_viewpoint_at_origin() { viewpoint_known_ = true; }
  /// Prepares an empty map for its first scan, which has this pose. The median range of its points
  /// tells whether the map begins in a room: rooms need smaller voxels than streets.
  void start_map(const Scan& scan, const Pose& T_odom_base, const SweepSampler& sweep,
                 LocalMap& map);
  bool is_indoors() const { return is_indoors_; }
  /// The next scan is not connected with the previous one.
  void interrupt();

  /// True if a scan with the pose of this state is to be inserted: the first ones, and then one
  /// whenever the sensor has moved on, so that standing still adds nothing.
  bool is_due(const TrackerState& state) const;
  /// Inserts the scan that was sampled last, at the pose of the state. Returns its dense points,
  /// which are valid until the next scan is sampled.
  const SampledPoints& insert(const Scan& scan, SweepSampler& sweep, TrackerState& state,
                              StepTimer& timer);
  /// Points between the rings of the map's first scan, to which its second scan is matched: in
  /// rooms those of the floor, none if the rings cannot be told apart. To be called after the
  /// insertion of that scan.
  SampledPoints first_points_between_rings(const Scan& scan, SweepSampler& sweep) const;
  /// To be called if the scan is not inserted: then there is time for the calibration.
  void skip(StepTimer& timer);
  /// To be called if the points of a scan at this pose did not observe a direction.
  void mark_open_field(const Pose& T_map_sensor) { ring_spacing_.mark_open_field(T_map_sensor); }

  /// To be called if the pose has jumped within the map.
  void reset_views() { moving_points_.clear(); }

  const ElevationCalibration& elevation() const { return elevation_; }
  /// Finds points on what moves, by the scans that were inserted.
  const MovingPointFinder& moving_points() const { return moving_points_; }

 private:
  /// Dense points of a scan, and the motion with which they were inserted.
  struct InsertedScan {
    SampledPoints points;
    MotionState motion;
  };

  void insert_points(const Scan& scan, const SampledPoints& dense, SweepSampler& sweep,
                     TrackerState& state);
  void insert_at(const MotionState& motion, const SampledPoints& points, LocalMap& map) const;
  void refine_when_filled(InsertedScan scan, LocalMap& map);

  double voxel_size_;
  bool calibrates_elevation_;
  bool viewpoint_known_ = false;
  bool is_indoors_ = false;  ///< the map began in a room
  bool is_young_ = false;    ///< its voxels are larger than those of a room, until they are filled
  std::vector<InsertedScan> young_scans_;  ///< the scans inserted so far, while it is young
  RingSpacingGate ring_spacing_;
  Pose start_pose_;      ///< pose of the map's first scan, at its stamp
  Pose last_insertion_;  ///< pose of the scan last inserted
  ElevationCalibration elevation_;
  MovingPointFinder moving_points_;
};

}  // namespace lidar_mapping::front_end
