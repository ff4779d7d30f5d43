// SPDX-License-Identifier: BSD-3-Clause
#include "local_map/elevation_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "local_map/elevation_pair.hpp"
#include "local_map/local_map.hpp"

namespace lidar_mapping::front_end {
namespace {

// Distance of the scans of a pair, in voxel edge lengths. The rings of a scan bend its planes a
// little. Measured: scans that are closer together give up to 0.04 degrees without any error.
constexpr double kMinPairDistance = 20.0;
// Distance between the scans that are kept, in the same unit. Chosen: kMaxFrames of them reach
// beyond kMinPairDistance.
constexpr double kMinFrameDistance = 3.0;
/// After this number of pairs the distance between frames grows. Chosen: one more then changes the
/// mean by a hundredth of its deviation, which is not worth its time.
constexpr double kDensePairs = 100.0;
/// Limit for a sensor that moves back and forth and never has two scans that are far enough apart.
/// Chosen: nearly twice what kMinPairDistance takes.
constexpr std::size_t kMaxFrames = 12;
/// Edge length of the voxels of that map, in voxel edge lengths of the odometry. A voxel of a
/// single scan holds few points, and planes through four of them hide the angle. Measured: in
/// clouds that were thinned out to 0.5 m, 0.2 degrees came out as 0.14 to 0.24, and as 0.19 to 0.21
/// with 1.5; a pair of 16 beams knows the angle to 0.1 degrees instead of 0.2. Twice gives 0.16 to
/// 0.21.
constexpr double kVoxelFactor = 1.5;
/// Voxels of the map of one scan. Chosen: more than a scan inserts points (12,000).
constexpr std::size_t kMapCapacity = std::size_t{1} << 14;

/// Lower bound of a pair's sigma, however many points it has. Chosen: the error that pairs of one
/// place have in common with 64 beams (see kCommonErrorFactor).
constexpr double kMinPairSigma = 0.03 * kRadPerDeg;
/// A more precise estimate is not needed. Chosen: a quarter of kMinAngle.
constexpr double kSufficientSigma = 0.012 * kRadPerDeg;
// Conditions for accepting the angle: number of pairs, size of the angle (twice the error of eleven
// simulated drives, 0.023 degrees), and number of standard deviations from zero. Measured: the
// key frames of KITTI 00 reach 7.8 of these, eighteen simulated drives without an error 2.6 at
// most.
constexpr int kMinPairs = 12;
constexpr double kMinAngle = 0.05 * kRadPerDeg;
constexpr double kMinSigmas = 5.0;
/// A place seen with few rings can show the same wrong angle in all pairs. The scatter of the pairs
/// does not show this error, and more pairs do not reduce it. Its standard deviation in units of a
/// pair's sigma. Measured, where nothing is wrong: up to 0.11 degrees in six towns, where pairs
/// have 0.09, and up to 0.18 in 24 car parks, where they have 0.12 (16 beams); 0.04 where they have
/// 0.035 (64 beams).
constexpr double kCommonErrorFactor = 0.6;
/// Smaller changes are noise. Chosen: the error of eleven simulated drives (0.023 degrees).
constexpr double kMinChange = 0.02 * kRadPerDeg;
/// Chosen: a step of this size moves the ground in the map by a centimetre (at 10 m). With a single
/// large step the pose would jump.
constexpr double kMaxAppliedStep = 0.05 * kRadPerDeg;

/// The plane model requires some width: a single ring on the ground does not define a plane.
registration::PlaneModel wide_plane_model() {
  registration::PlaneModel model;
  model.least_breadth = 0.08;
  model.sure_breadth = 0.16;
  return model;
}

double position_distance(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm();
}

double square(double value) { return value * value; }

}  // namespace

void ElevationMean::add(const ElevationEstimate& estimate) {
  const double w = 1.0 / (square(estimate.sigma) + square(kMinPairSigma));
  const double x = estimate.angle;
  ++count_;
  w_ += w;
  wx_ += w * x;
  ww_ += w * w;
  wwx_ += w * w * x;
  wwxx_ += w * w * x * x;
}

double ElevationMean::typical_sigma() const { return std::sqrt(count_ / w_); }

ElevationEstimate ElevationMean::value() const {
  if (count_ == 0) return {};
  const double mean = wx_ / w_;
  const double scatter = wwxx_ - 2.0 * mean * wwx_ + mean * mean * ww_;
  return {mean, std::sqrt(std::max(w_, scatter)) / w_};
}

ElevationCalibration::ElevationCalibration() : map_(1.0, kMapCapacity, wide_plane_model()) {}

void ElevationCalibration::add_scan(const SampledPoints& points, const MotionState& state,
                                    double voxel_size) {
  compare_pending();
  if (is_converged()) {
    interrupt();
  } else if (frames_.empty() ||
             position_distance(frames_.back().T_map_sensor, state.T_map_sensor) >=
                 frame_distance() * voxel_size) {
    Frame frame{{}, state.T_map_sensor, voxel_size};
    transform_points(points, {Pose{}, state.twist}, Eigen::Vector3d::Zero(), frame.points);
    rotate_upwards(frame.points, -applied_angle_);
    if (frames_.size() == kMaxFrames) frames_.pop_front();
    frames_.push_back(std::move(frame));
    comparison_pending_ = true;
  }
  applied_angle_ += std::clamp(accepted_angle_ - applied_angle_, -kMaxAppliedStep, kMaxAppliedStep);
}

void ElevationCalibration::interrupt() {
  frames_.clear();
  comparison_pending_ = false;
}

/// Among the scans that are far enough away, the newest one shares most of the view.
void ElevationCalibration::compare_pending() {
  if (!comparison_pending_) return;
  comparison_pending_ = false;
  const Frame& frame = frames_.back();
  const auto partner = std::find_if(frames_.rbegin(), frames_.rend(), [&](const Frame& earlier) {
    return position_distance(earlier.T_map_sensor, frame.T_map_sensor) >=
           kMinPairDistance * frame.voxel_size;
  });
  if (partner == frames_.rend()) return;
  map_.restart(kVoxelFactor * frame.voxel_size);
  // The error caused by bent planes changes its sign when the two scans change their roles.
  const bool swap_roles = mean_.count() % 2 == 1;
  compare(swap_roles ? frame : *partner, swap_roles ? *partner : frame);
}

/// True if the angle is known well enough, and it is either accepted or too small to be accepted.
bool ElevationCalibration::is_converged() const {
  const ElevationEstimate mean = mean_.value();
  return mean_.count() >= kMinPairs && mean.sigma < kSufficientSigma &&
         (accepted_angle_ != 0.0 || std::abs(mean.angle) < kMinAngle);
}

/// Distance between the scans that are compared, in voxel edge lengths.
double ElevationCalibration::frame_distance() const {
  return kMinFrameDistance * std::max(1.0, mean_.count() / kDensePairs);
}

void ElevationCalibration::compare(const Frame& a, const Frame& b) {
  map_.insert(a.points.x.data(), a.points.y.data(), a.points.z.data(), a.points.size());
  const auto of_pair =
      estimate_elevation(b.points, map_, a.T_map_sensor.inverse() * b.T_map_sensor);
  if (!of_pair) return;
  mean_.add(*of_pair);
  decide();
}

ElevationEstimate ElevationCalibration::estimate() const {
  ElevationEstimate mean = mean_.value();
  if (mean_.count() > 0)
    mean.sigma = std::hypot(mean.sigma, kCommonErrorFactor * mean_.typical_sigma());
  return mean;
}

void ElevationCalibration::decide() {
  const ElevationEstimate mean = estimate();
  const bool is_significant = mean_.count() >= kMinPairs && std::abs(mean.angle) > kMinAngle &&
                              std::abs(mean.angle) > kMinSigmas * mean.sigma;
  if (is_significant && std::abs(mean.angle - accepted_angle_) > kMinChange)
    accepted_angle_ = mean.angle;
}

}  // namespace lidar_mapping::front_end
