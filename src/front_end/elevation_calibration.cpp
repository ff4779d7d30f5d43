// SPDX-License-Identifier: BSD-3-Clause
#include "elevation_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "elevation_pair.hpp"
#include "local_map.hpp"

namespace lidar_mapping::front_end {
namespace {

// In edges of voxels. Planes are bent a little by the rings of the scan that they come from; in
// scans that are closer together that passes for an angle of some hundredths of a degree.
constexpr double kMinPairDistance = 20.0;
constexpr double kMinFrameDistance = 3.0;
/// After so many pairs they become rarer.
constexpr double kDensePairs = 100.0;
/// A sensor that goes to and fro never has two scans that are far enough apart.
constexpr std::size_t kMaxFrames = 12;
constexpr std::size_t kMapCapacity = std::size_t{1} << 14;

/// A pair is worth no more than that, however many points it has.
constexpr double kMinPairSigma = 0.03 * kRadPerDeg;
/// Better than that nobody needs to know it.
constexpr double kSufficientSigma = 0.012 * kRadPerDeg;
// What is believed: from so many pairs, so large an angle, so many standard deviations from zero.
constexpr int kMinPairs = 12;
constexpr double kMinAngle = 0.05 * kRadPerDeg;
constexpr double kMinSigmas = 5.0;
/// What few rings show of a place pretends the same angle in all pairs, which their scatter does
/// not tell and more pairs do not mend: standard deviation of that in units of a pair's. Angles of
/// zero came out as 0.03 degrees where pairs have 0.05 (64 beams), as 0.3 where they have 0.25
/// (simulated car parks with 16 beams).
constexpr double kCommonErrorFactor = 0.6;
/// Smaller changes are noise.
constexpr double kMinChange = 0.02 * kRadPerDeg;
/// So much more per scan in the map moves the ground by a centimetre. All at once the pose would
/// jump.
constexpr double kMaxAppliedStep = 0.05 * kRadPerDeg;

/// One ring on the ground makes no plane.
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

void ElevationCalibration::add_scan(const SampledPoints& points,
                                    const registration::MotionState& state, double voxel_size) {
  compare_pending();
  if (is_converged()) {
    interrupt();
  } else if (frames_.empty() ||
             position_distance(frames_.back().T_map_sensor, state.T_map_sensor) >=
                 frame_distance() * voxel_size) {
    Frame frame{{}, state.T_map_sensor, voxel_size};
    place(points, {Pose{}, state.twist}, Eigen::Vector3d::Zero(), frame.points);
    raise(frame.points, -applied_angle_);
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

/// Of the scans that are far enough away the newest one has seen most of the same.
void ElevationCalibration::compare_pending() {
  if (!comparison_pending_) return;
  comparison_pending_ = false;
  const Frame& frame = frames_.back();
  const auto partner = std::find_if(frames_.rbegin(), frames_.rend(), [&](const Frame& earlier) {
    return position_distance(earlier.T_map_sensor, frame.T_map_sensor) >=
           kMinPairDistance * frame.voxel_size;
  });
  if (partner == frames_.rend()) return;
  map_.restart(frame.voxel_size);
  // What bent planes pretend changes its sign with the roles of the two.
  const bool swap_roles = mean_.count() % 2 == 1;
  compare(swap_roles ? frame : *partner, swap_roles ? *partner : frame);
}

/// The angle is known well enough, and it is either believed or too small for that.
bool ElevationCalibration::is_converged() const {
  const ElevationEstimate mean = mean_.value();
  return mean_.count() >= kMinPairs && mean.sigma < kSufficientSigma &&
         (accepted_angle_ != 0.0 || std::abs(mean.angle) < kMinAngle);
}

/// Distance between the scans that are looked at, in edges of voxels.
double ElevationCalibration::frame_distance() const {
  return kMinFrameDistance * std::max(1.0, mean_.count() / kDensePairs);
}

void ElevationCalibration::compare(const Frame& a, const Frame& b) {
  map_.insert(a.points.x.data(), a.points.y.data(), a.points.z.data(), a.points.size());
  const auto accepted_angle =
      estimate_elevation(b.points, map_, a.T_map_sensor.inverse() * b.T_map_sensor);
  if (!accepted_angle) return;
  mean_.add(*accepted_angle);
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
