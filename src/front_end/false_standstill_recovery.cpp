// SPDX-License-Identifier: BSD-3-Clause
#include "false_standstill_recovery.hpp"

#include <cmath>
#include <utility>

#include "lidar_mapping/common/units.hpp"

#include "degeneracy.hpp"
#include "local_map.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Where more of the points find a plane, and these hold the sensor in all directions, it does not
/// go unnoticed.
constexpr double kEnoughPlanes = 0.5;
/// Fewer upright points tell nothing.
constexpr std::size_t kFewest = 20;
/// More of them, as streets have, tell no more and take time.
constexpr std::size_t kMostCompared = 400;
/// As long as this share of them is where it was, the sensor is, too.
constexpr double kStillThere = 0.6;
/// At the new pose they fit in at least so many of 36 directions, and so much better than at the
/// old one: in each scan, and in all of them together by so many standard deviations.
constexpr int kFewestDirections = 4;
constexpr double kMore = 1.25;
constexpr double kSignificant = 4.0;
/// So many scans have to tell of a motion that is steady to this (m).
constexpr std::size_t kScans = 3;
constexpr double kSteady = 0.25;

/// A robot that turns on the spot goes on putting scans into its map.
constexpr int kMostScans = 10;

// Where to look (m); ahead may be any of four directions of the sensor's.
constexpr int kDirections = 4;
constexpr double kBehind = 2.4;
constexpr double kAhead = 6.0;
constexpr double kAside = 0.6;
constexpr double kStep = 0.3;

/// What runs along the way fits as well so far before and behind (m), and tells nothing.
constexpr double kBeside = 0.7;
/// A shorter way (m) or a slower motion (m/s) has no direction.
constexpr double kLeastWay = 0.1;
/// After so many scans without a fit the matches are trusted again.
constexpr int kMostMisses = 10;
/// From here on there are rings of many places in the map (m).
constexpr double kFollowedWay = 30.0;

// What a fit tells, and three of them.
constexpr double kPlaceSigma = 0.15;       // m
constexpr double kPlaceAngleSigma = 0.01;  // rad
constexpr double kSpeedSigma = 0.5;        // m/s
constexpr double kRateSigma = 0.1;         // rad/s

/// Upright points as they were at the reference time.
std::vector<Eigen::Vector3f> upright_at(const SampledPoints& points, const Vector6d& twist) {
  SampledPoints placed;
  place(points, {Pose{}, twist}, Eigen::Vector3d::Zero(), placed);
  return upright_points(placed);
}

/// Of them about as many as are compared.
std::vector<Eigen::Vector3f> some_upright_at(const SampledPoints& points, const Vector6d& twist) {
  std::vector<Eigen::Vector3f> upright = upright_at(points, twist);
  const std::size_t step = upright.size() / kMostCompared + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < upright.size(); i += step) upright[kept++] = upright[i];
  upright.resize(kept);
  return upright;
}

Pose displaced(const Pose& pose, const Eigen::Vector2d& by) {
  Vector6d d = Vector6d::Zero();
  d.head<2>() = by;
  return perturbed(pose, d);
}

/// Of unit length; the sensor's x where there is none.
Eigen::Vector2d direction_of(const Vector6d& way) {
  const Eigen::Vector2d level = way.head<2>();
  return level.norm() < kLeastWay ? Eigen::Vector2d::UnitX() : level.normalized();
}

Matrix12d covariance_of_found() {
  Matrix12d covariance = Matrix12d::Zero();
  covariance.topLeftCorner<6, 6>() = diagonal_covariance(kPlaceSigma, kPlaceAngleSigma);
  covariance.bottomRightCorner<6, 6>() = diagonal_covariance(kSpeedSigma, kRateSigma);
  return covariance;
}

bool is_held(const registration::NdtMatch& match) {
  return match.overlap > kEnoughPlanes &&
         degenerate_directions(match.pose_hessian, kOnePlaceShare).empty();
}

}  // namespace

void FalseStandstillRecovery::forget() { *this = FalseStandstillRecovery(); }

void FalseStandstillRecovery::insert(const SampledPoints& points, const MotionState& state) {
  if (over_ || (!found_ && scans_ == kMostScans)) return;
  ++scans_;
  if (!first_) first_ = sure_ = state.T_map_sensor;
  inserted_.push_back({points, state});
}

void FalseStandstillRecovery::take_inserted() {
  for (const Inserted& scan : inserted_) {
    map_.insert(upright_at(scan.points, scan.state.twist), scan.state.T_map_sensor);
  }
  inserted_.clear();
}

void FalseStandstillRecovery::end() {
  forget();
  over_ = true;
}

bool FalseStandstillRecovery::follow(const SampledPoints& points, const MotionFilter& agile,
                                     MotionFilter& filter) {
  if (!found_) return false;
  const MotionState& predicted = agile.state();
  const Pose& where = filter.state().T_map_sensor;
  if ((where.translation - first_->translation).norm() > kFollowedWay) {
    end();
    return false;
  }
  take_inserted();
  const std::optional<Pose> pose = fit(points, predicted);
  filter = agile;
  if (pose) filter.measure_place(*pose, kPlaceSigma, kPlaceAngleSigma);
  return true;
}

bool FalseStandstillRecovery::notice(const SampledPoints& points,
                                     const registration::NdtMatch& match, double seconds,
                                     bool one_place, MotionFilter& filter) {
  if (!one_place || !first_) end();
  if (over_) return false;
  since_step_ += seconds;
  if (is_held(match)) {
    trust(match.state.T_map_sensor);
    return false;
  }
  take_inserted();
  const std::optional<MotionState> state = look(points, match.state);
  if (state) filter.restart(*state, covariance_of_found());
  return state.has_value();
}

void FalseStandstillRecovery::trust(const Pose& pose) {
  sure_ = pose;
  steps_.clear();
}

const Pose& FalseStandstillRecovery::last_place() const {
  return steps_.empty() ? sure_ : steps_.back().pose;
}

Pose FalseStandstillRecovery::roughly(const std::vector<Eigen::Vector3f>& points) const {
  Pose best = last_place();
  std::size_t most = 0;
  for (int direction = 0; direction < kDirections; ++direction) {
    const Eigen::Rotation2Dd course(2.0 * kPi / kDirections * direction);
    for (double x = -kBehind; x <= kAhead + 1e-9; x += kStep) {
      for (double y = -kAside; y <= kAside + 1e-9; y += kStep) {
        const Pose there = displaced(last_place(), course * Eigen::Vector2d(x, y));
        const std::size_t near = map_.count_near(points, there);
        if (near <= most) continue;
        most = near;
        best = there;
      }
    }
  }
  return best;
}

std::optional<FalseStandstillRecovery::Step> FalseStandstillRecovery::elsewhere(
    const std::vector<Eigen::Vector3f>& points, const Pose& matched) {
  if (points.size() < kFewest) return std::nullopt;
  const VerticalStructureMap::Fit here = map_.evaluate(points, matched);
  if (static_cast<double>(here.seen_again) > kStillThere * static_cast<double>(points.size())) {
    trust(matched);
    return std::nullopt;
  }
  const VerticalStructureMap::Fit there = map_.fit(points, roughly(points));
  if (there.evidence <= here.evidence) steps_.clear();
  const Eigen::Vector2d ahead = direction_of(difference(last_place(), there.T_map_sensor));
  if (there.evidence < kMore * here.evidence || !is_place(there, ahead, points)) {
    return std::nullopt;
  }
  return Step{there.T_map_sensor, 0.0, there.evidence, here.evidence};
}

bool FalseStandstillRecovery::is_steady() const {
  int more = 0;
  int all = 0;
  for (const Step& step : steps_) {
    more += step.there - step.here;
    all += step.there + step.here;
  }
  if (more < kSignificant * std::sqrt(all)) return false;
  const double seconds = steps_[1].seconds + steps_[2].seconds;
  const Vector6d twist = twist_between(steps_[0].pose, steps_[2].pose, seconds);
  const Pose between = moved(steps_[0].pose, twist, steps_[1].seconds);
  return difference(between, steps_[1].pose).head<3>().norm() < kSteady;
}

std::optional<MotionState> FalseStandstillRecovery::look(const SampledPoints& points,
                                                         const MotionState& matched) {
  std::optional<Step> step =
      elsewhere(some_upright_at(points, matched.twist), matched.T_map_sensor);
  if (!step) return std::nullopt;
  step->seconds = std::exchange(since_step_, 0.0);
  if (steps_.size() == kScans) steps_.erase(steps_.begin());
  steps_.push_back(*step);
  if (steps_.size() < kScans || !is_steady()) return std::nullopt;
  found_ = true;
  const double seconds = steps_[1].seconds + steps_[2].seconds;
  return MotionState{step->pose, twist_between(steps_[0].pose, step->pose, seconds)};
}

bool FalseStandstillRecovery::is_place(const VerticalStructureMap::Fit& fit,
                                       const Eigen::Vector2d& ahead,
                                       const std::vector<Eigen::Vector3f>& points) const {
  const Pose& pose = fit.T_map_sensor;
  const int behind = map_.evaluate(points, displaced(pose, -kBeside * ahead)).evidence;
  const int before = map_.evaluate(points, displaced(pose, kBeside * ahead)).evidence;
  return fit.directions >= kFewestDirections && fit.evidence > kMore * 0.5 * (behind + before);
}

std::optional<Pose> FalseStandstillRecovery::fit(const SampledPoints& points,
                                                 const MotionState& predicted) {
  const std::vector<Eigen::Vector3f> upright = some_upright_at(points, predicted.twist);
  const VerticalStructureMap::Fit fit = map_.fit(upright, predicted.T_map_sensor);
  if (is_place(fit, direction_of(predicted.twist), upright)) {
    misses_ = 0;
    return fit.T_map_sensor;
  }
  if (++misses_ == kMostMisses) {
    misses_ = 0;
    found_ = false;
    trust(predicted.T_map_sensor);
  }
  return std::nullopt;
}

}  // namespace lidar_mapping::front_end
