// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/local_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "key_frame_rule.hpp"

namespace lidar_mapping::front_end {
namespace {

// A scan is inserted after one of these motions.
constexpr double kInsertionDistance = 2.0;  // m; chosen
constexpr double kInsertionAngle = 0.1;     // rad; chosen
/// Scans with fewer points are inserted after a motion that is shorter in proportion, so that the
/// voxels on the way get as many points. Measured on nine drives of 500 points per scan: at 1000
/// three drives drift by more than 1 %, at 4000 and 8000 none by more than 0.5 %. The scans of a
/// sensor with 16 beams have more than 10,000 points.
constexpr double kFullScan = 4000.0;
/// The first scans are always inserted, and outside of rooms together with points between their
/// rings: planes of single rings fit at any pitch of the vehicle, and it pitches when it starts to
/// move. Tried: with such points in all scans three drives drift by 0.0247 % instead of 0.0208 %.
constexpr int kInitialScans = 3;

/// Median range of the sampled points (m) up to which a scan counts as taken indoors. Measured: in
/// recorded rooms it is at most 6, in recorded streets at least 15; sensors with a narrow view are
/// between 7 and 14 in simulated rooms. A scan of few points is not thinned out, so its median is
/// another one, and its voxels are as large as outdoors anyway.
constexpr double kIndoorRange = 12.0;
/// Smallest factor for all voxel sizes indoors. Chosen: the surfaces of a room are small.
constexpr double kIndoorVoxelScale = 0.5;
/// A young map has larger voxels if a scan has fewer points, so that as many points are in each,
/// but at most as large as outdoors. Measured on 103 drives in rooms (doc/results/front_end.md):
/// with it the errors of 16 beams are half as large, and those of 64 beams the same.
constexpr double kPointsForSmallVoxels = 90000.0;
/// A map in a room is young until so many scans were inserted. Measured with 16 beams
/// (doc/results/front_end.md): the same errors with 10 and 20, but false alarms after 20; never, a
/// drive of 25 s drifts six times as much.
constexpr std::size_t kScansOfYoungMap = 10;
/// One of so many of their points is matched when the map is built anew. Chosen: as many as in a
/// match of the odometry.
constexpr std::size_t kRefinementThinning = 4;

/// Up to this distance from its start (in voxels), the map counts as a map of a single place.
/// Chosen; half and twice of it move nothing (doc/results/ablation.md).
constexpr double kSinglePlaceRadius = 10.0;

double scan_density(const Scan& scan) {
  return std::min(1.0, static_cast<double>(scan.cloud.size()) / kFullScan);
}

double indoor_voxel_scale(const Scan& scan) {
  const double ratio = kPointsForSmallVoxels / static_cast<double>(scan.cloud.size());
  return std::clamp(kIndoorVoxelScale * std::sqrt(ratio), kIndoorVoxelScale, 1.0);
}

/// Prior of a motion that was found with large voxels: their errors (0.1 m, 0.02 rad), and twists
/// that stay as they are. Chosen above what steps in young maps are off by.
MotionBelief young_motion(const MotionState& motion) {
  MotionBelief belief{motion, Matrix12d::Zero()};
  belief.information.diagonal() << Eigen::Vector3d::Constant(1.0 / (0.1 * 0.1)),
      Eigen::Vector3d::Constant(1.0 / (0.02 * 0.02)), Vector6d::Constant(1e4);
  return belief;
}

/// The motion with which the points fit to the map.
MotionState matched(const SampledPoints& points, const MotionState& motion, NdtMatcher& matcher,
                    LocalMap& map) {
  NdtPoints all, some;
  all.assign(points.x, points.y, points.z, points.s, points.viewpoint);
  some.assign_thinned(all, kRefinementThinning);
  const auto match = matcher.match(some, map.fine(), young_motion(motion), motion, {});
  return match.converged ? match.state : motion;
}

}  // namespace

void LocalMapper::start_map(const Scan& scan, const Pose& T_odom_base, const SweepSampler& sweep,
                            LocalMap& map) {
  start_pose_ = T_odom_base;
  is_indoors_ = scan_density(scan) == 1.0 && sweep.median_range() <= kIndoorRange;
  const double scale = is_indoors_ ? indoor_voxel_scale(scan) : 1.0;
  map.restart(scale * voxel_size_);
  is_young_ = is_indoors_ && scale > kIndoorVoxelScale;
  young_scans_.clear();
  ring_spacing_ =
      RingSpacingGate(viewpoint_known_ ? ring_spacing(scan.cloud, Eigen::Vector3d::Zero()) : 0.0);
}

void LocalMapper::interrupt() {
  elevation_.interrupt();
  moving_points_.clear();
}

bool LocalMapper::is_due(const TrackerState& state) const {
  KeyFrameRule rule;
  rule.distance = kInsertionDistance;
  rule.angle = kInsertionAngle;
  return state.coverage.inserted_scans < kInitialScans ||
         rule.scaled(state.map.scan_density())
             .motion_reached(last_insertion_.inverse() * state.filter.state().T_map_sensor);
}

const SampledPoints& LocalMapper::insert(const Scan& scan, SweepSampler& sweep, TrackerState& state,
                                         StepTimer& timer) {
  timer.start("dense sampling");
  const SampledPoints& dense = sweep.sample_dense(scan);
  timer.start("insertion");
  PointMarks moving;
  if (sweep.leaves_out_points()) moving = moving_points_.find(dense, state.filter.state());
  moving_points_.add_view(dense, state.filter.state());
  if (!moving.empty()) sweep.leave_out_of_dense(moving);
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
  state.map.set_scan_density(scan_density(scan));
  insert_at(motion, dense, state.map);
  if (is_young_) refine_when_filled({dense, motion}, state.map);
  // The surfaces of a room are small, and many rings hit each of them: with these points, the
  // error of a recorded sensor of 16 beams that stands in a room is 15 mm instead of 5.
  if (!is_indoors_ && state.coverage.inserted_scans < kInitialScans) {
    state.map.insert(sweep.sample_between_rings(scan, RingSurfaces::kAll), motion);
  }
  ++state.coverage.inserted_scans;
  last_insertion_ = motion.T_map_sensor;
  if ((last_insertion_.translation - start_pose_.translation).norm() >
      kSinglePlaceRadius * state.map.fine().resolution()) {
    state.coverage.is_single_place = false;
  }
}

SampledPoints LocalMapper::first_points_between_rings(const Scan& scan, SweepSampler& sweep) const {
  if (!is_indoors_) return sweep.between_rings();  // as inserted
  if (ring_spacing_.spacing_at(start_pose_) == 0.0) return {};
  return sweep.sample_between_rings(scan, RingSurfaces::kGround);
}

void LocalMapper::insert_at(const MotionState& motion, const SampledPoints& points,
                            LocalMap& map) const {
  map.set_ring_spacing(ring_spacing_.spacing_at(motion.T_map_sensor));
  map.insert(points, motion);
}

/// Builds the map anew with small voxels as soon as there are scans to fill them: from the newest
/// one back, each matched to those that are in it already, because the large voxels have blurred
/// their poses. The newest pose stays.
void LocalMapper::refine_when_filled(InsertedScan scan, LocalMap& map) {
  young_scans_.push_back(std::move(scan));
  if (young_scans_.size() < kScansOfYoungMap) return;
  map.restart(kIndoorVoxelScale * voxel_size_);
  NdtMatcher matcher;
  for (auto young = young_scans_.rbegin(); young != young_scans_.rend(); ++young) {
    if (young != young_scans_.rbegin())
      young->motion = matched(young->points, young->motion, matcher, map);
    insert_at(young->motion, young->points, map);
  }
  young_scans_.clear();
  is_young_ = false;
}

void LocalMapper::skip(StepTimer& timer) {
  timer.start("calibration");
  elevation_.compare_pending();
}

}  // namespace lidar_mapping::front_end
