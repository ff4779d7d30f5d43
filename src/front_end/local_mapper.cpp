// SPDX-License-Identifier: BSD-3-Clause
#include "local_mapper.hpp"

#include "key_frame_rule.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A scan is inserted after this motion.
const KeyFrameRule kInsertionRule{2.0, 0.1, 0.0};
/// The first scans are always inserted, and outside of rooms together with points between their
/// rings: planes of single rings fit at any pitch of the vehicle, and it pitches when it starts to
/// move. Tried: with such points in all scans three drives drift by 0.0247 % instead of 0.0208 %.
constexpr int kInitialScans = 3;

/// Median range of the points (m) below which a scan counts as taken indoors, and the factor for
/// all voxel sizes indoors. Chosen; measured at half and twice: some drives gain, others lose
/// (doc/results/ablation.md).
constexpr double kIndoorRange = 7.0;
constexpr double kIndoorVoxelScale = 0.5;

/// Up to this distance from its start (in voxels), the map counts as a map of a single place.
/// Chosen; half and twice of it move nothing (doc/results/ablation.md).
constexpr double kSinglePlaceRadius = 10.0;

}  // namespace

void LocalMapper::start_map(const Scan& scan, const Pose& T_odom_base, const SweepSampler& sweep,
                            LocalMap& map) {
  start_pose_ = T_odom_base;
  is_indoors_ = sweep.median_range() <= kIndoorRange;
  map.restart(is_indoors_ ? kIndoorVoxelScale * voxel_size_ : voxel_size_);
  ring_spacing_ =
      RingSpacingGate(viewpoint_known_ ? ring_spacing(scan.cloud, Eigen::Vector3d::Zero()) : 0.0);
}

bool LocalMapper::is_due(const TrackerState& state) const {
  return state.coverage.inserted_scans < kInitialScans ||
         kInsertionRule.reached(last_insertion_.inverse() * state.filter.state().T_map_sensor, 0);
}

const SampledPoints& LocalMapper::insert(const Scan& scan, SweepSampler& sweep, TrackerState& state,
                                         StepTimer& timer) {
  timer.start("dense sampling");
  const SampledPoints& dense = sweep.sample_dense(scan);
  timer.start("insertion");
  insert_points(scan, dense, sweep, state);
  if (!calibrates_elevation_ || state.coverage.inserted_scans <= kInitialScans) return dense;
  timer.start("calibration");
  elevation_.add_scan(dense, state.filter.state(), state.map.fine().resolution());
  sweep.set_elevation_shift(elevation_.applied_angle());
  return dense;
}

void LocalMapper::insert_points(const Scan& scan, const SampledPoints& dense, SweepSampler& sweep,
                                TrackerState& state) {
  const MotionState& motion = state.filter.state();
  state.map.set_ring_spacing(ring_spacing_.spacing_at(motion.T_map_sensor));
  state.map.insert(dense, motion);
  // The surfaces of a room are small, and many rings hit each of them: with these points, the
  // error of a recorded sensor of 16 beams that stands in a room is 15 mm instead of 5.
  if (!is_indoors_ && state.coverage.inserted_scans < kInitialScans) {
    state.map.insert(sweep.sample_between_rings(scan), motion);
  }
  ++state.coverage.inserted_scans;
  last_insertion_ = motion.T_map_sensor;
  if ((last_insertion_.translation - start_pose_.translation).norm() >
      kSinglePlaceRadius * state.map.fine().resolution()) {
    state.coverage.is_single_place = false;
  }
}

void LocalMapper::skip(StepTimer& timer) {
  timer.start("calibration");
  elevation_.compare_pending();
}

}  // namespace lidar_mapping::front_end
