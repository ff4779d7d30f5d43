#include "lidar_mapping/front_end/ndt_tracker.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "lidar_mapping/front_end/degeneracy.hpp"
#include "lidar_mapping/front_end/elevation_calibration.hpp"
#include "lidar_mapping/front_end/first_scans.hpp"
#include "lidar_mapping/front_end/key_frame_rule.hpp"
#include "lidar_mapping/front_end/local_map.hpp"
#include "lidar_mapping/front_end/match_judge.hpp"
#include "lidar_mapping/front_end/motion_filter.hpp"
#include "lidar_mapping/front_end/search_starts.hpp"
#include "lidar_mapping/front_end/step_timer.hpp"
#include "lidar_mapping/front_end/sweep_matcher.hpp"
#include "lidar_mapping/front_end/sweep_sampler.hpp"
#include "lidar_mapping/front_end/velocity_trust.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionBelief;
using registration::NdtMatch;

/// A scan goes into the local map after this motion; so standing still adds nothing.
const KeyFrameRule kInsertionRule{2.0, 0.1, 0.0};
/// The first scans go into it wherever they are.
constexpr int kFirstScans = 3;
/// Until the sensor is so far from where the map began (in voxels), it is a map of one place.
constexpr double kOnePlace = 10.0;
/// Fewer points are no scan.
constexpr std::size_t kMinPoints = 50;

/// Median distance of the points (m) below which a scan is taken in a room, and what that does to
/// all voxels.
constexpr double kRoomRange = 7.0;
constexpr double kRoomScale = 0.5;

// What is believed of the motion before the second scan.
constexpr double kInitialSpeedSigma = 15.0;  // m/s
constexpr double kInitialRateSigma = 1.0;    // rad/s
// The first scans are looked at again if the vehicle begins faster than that, as key frames of a
// slower one would wait too long for the map to grow, and if fewer of the points of the second scan
// find a plane in the map of the first: with many rings it is good enough.
constexpr double kAtSpeed = 3.0;  // m/s
constexpr double kEnoughPlanes = 0.4;
/// Rounds of deskewing the first scan and matching the second one with it.
constexpr int kStartRounds = 3;
// Twists that differ by less move no point by more than the sensor's noise.
constexpr double kSameSpeed = 0.02;  // m/s
constexpr double kSameRate = 1e-3;   // rad/s

// Measured twists belong to the stamp, the filter's to the middle of the sweep.
constexpr double kGyroSigma = 0.1;  // rad/s

/// Weight of the points in the covariance that is reported, in units of their weight in the filter.
constexpr double kReportedWeight = 24.0;

// A map of few scans of a sensor with few rings has planes that lean, and all points that meet one
// err together: the fewer of them find a plane, the worse. Measured on simulated drives.
constexpr int kYoungScans = 12;
constexpr double kYoungOverlap = 0.75;  // share of points with a plane that is enough
constexpr double kLeastOverlap = 0.45;
constexpr double kYoungPower = 8.0;

double variance_of_young_map(double overlap) {
  return std::pow(kYoungOverlap / std::clamp(overlap, kLeastOverlap, kYoungOverlap), kYoungPower);
}

/// While lost, the speed falls by 1/e in this time.
constexpr double kHoldTime = 1.0;  // s

bool is_same_motion(const Vector6d& a, const Vector6d& b) {
  const Vector6d d = a - b;
  return d.head<3>().norm() < kSameSpeed && d.tail<3>().norm() < kSameRate;
}

}  // namespace

class NdtTracker::Impl {
 public:
  explicit Impl(const FrontEndConfig& config)
      : config_(config),
        sampler_(config),
        map_(config.voxel_size, config.local_map_radius),
        filter_(config.acceleration_sigma, config.angular_acceleration_sigma),
        judge_(config.max_speed),
        matcher_(config.registration.neighbor_search),
        first_scans_(config.registration.neighbor_search) {}

  TrackedScan track(const Scan& scan, const MotionPrior& prior) {
    timer_.start("sampling");
    const double last_reference = sampler_.reference();
    sampler_.take(scan, scans_++);
    TrackedScan result;
    result.status.elevation_shift = elevation_.found();
    result.elevation_shift = elevation_.applied();
    if (map_.empty()) {
      if (prior.T_odom_base_initial) start_ = *prior.T_odom_base_initial;
      begin(scan, start_, result.status);
    } else {
      const double seconds =
          to_seconds(scan.stamp - stamp_) + sampler_.reference() - last_reference;
      timer_.start("matching");
      predict(seconds, prior);
      follow(scan, seconds, prior, result);
    }
    stamp_ = scan.stamp;
    timer_.start("ageing");
    map_.follow(filter_.state().T_map_sensor.translation);
    report(result);
    return result;
  }

  void set_sensor_origin(const Eigen::Vector3d& p_base_sensor) {
    sampler_.set_sensor_origin(p_base_sensor);
  }

  void restart(const Pose& T_odom_base) {
    forget();
    start_ = T_odom_base;
  }

  void settle() { first_scans_.end(); }

  PointCloud local_map() const { return map_.cloud(); }

 private:
  void forget() {
    map_.clear();
    judge_.reset();
    elevation_.interrupt();
    first_scans_.end();
    inserted_scans_ = 0;
    lost_time_ = 0.0;
    motion_known_ = false;
    one_place_ = true;
  }

  /// The first scan of a map. Its points are kept until the motion during it is known.
  void begin(const Scan& scan, const Pose& T_odom_base, FrontEndStatus& status) {
    start_ = last_good_ = T_odom_base;
    // The pose is known at the stamp, the filter's time is the middle of the sweep.
    filter_.reset(T_odom_base, kInitialSpeedSigma, kInitialRateSigma);
    filter_.predict(sampler_.reference());
    covariance_ = filter_.covariance();
    map_.begin(voxel_size());
    if (sampler_.points().size() < kMinPoints) {
      status.state = TrackingState::kLost;
      return;
    }
    status.state = TrackingState::kTracking;
    status.converged = true;
    first_scans_.begin();
    remember(scan);
    insert(scan);
    first_ = sampler_.dense(scan);
    first_has_times_ = scan.cloud.has_times();
    first_reference_ = sampler_.reference();
  }

  /// Rooms want smaller voxels than streets; which it is the first scan of a map tells.
  double voxel_size() const {
    return sampler_.median_range() > kRoomRange ? config_.voxel_size
                                                : kRoomScale * config_.voxel_size;
  }

  void predict(double seconds, const MotionPrior& prior) {
    filter_.predict(seconds);
    if (prior.angular_velocity) filter_.measure_rate(*prior.angular_velocity, kGyroSigma);
    if (prior.linear_velocity) {
      filter_.measure_velocity(velocity_trust_.corrected(*prior.linear_velocity),
                               velocity_trust_.cautious_sigma(prior.linear_velocity->norm()));
    }
  }

  void follow(const Scan& scan, double seconds, const MotionPrior& prior, TrackedScan& result) {
    const Prediction prediction{filter_.belief(), trusting_velocity(prior)};
    const SweepMatcher::Found found =
        motion_known_ ? matcher_.find(sampler_.points(), map_, judge_, prediction, {last_good_})
                      : find_first_motion(prediction.usual, seconds);
    describe(found, result.status);
    result.status.state = judge_.judge(found.match, prediction.usual);
    if (result.status.state == TrackingState::kLost) {
      hold(scan, seconds, result);
      return;
    }
    if (!motion_known_) know_first_motion(found.match);
    accept(found, prior, result.status);
    remember(scan);
    if (result.status.state != TrackingState::kDegraded) keep(scan, found.degenerate_directions);
    if (first_scans_.is_open() && first_scans_.look_again(filter_, judge_, map_)) {
      result.revisions = revisions();
    }
  }

  void remember(const Scan& scan) {
    if (!first_scans_.is_open()) return;
    first_scans_.add({scan.stamp,
                      sampler_.reference(),
                      sampler_.points(),
                      filter_.state(),
                      filter_.covariance(),
                      {}});
  }

  void know_first_motion(const NdtMatch& match) {
    if (!first_scans_.is_open()) return;
    const Vector6d& twist = match.state.twist;
    first_scans_.set_first({moved(start_, twist, first_reference_), twist});
    if (twist.head<3>().norm() < kAtSpeed || match.overlap > kEnoughPlanes) first_scans_.end();
  }

  std::vector<Revision> revisions() {
    const auto& found = first_scans_.found();
    std::vector<Revision> revisions;
    for (std::size_t i = 0; i < found.size(); ++i) {
      revisions.push_back(revision_of(found[i], first_scans_.scans()[i].reference));
    }
    first_scans_.end();
    return revisions;
  }

  static Revision revision_of(const SweepMatcher::Found& found, double reference) {
    const MotionState& state = found.match.state;
    const Matrix12d covariance =
        variance_of_young_map(found.match.overlap) * reported_covariance(found.match);
    return {moved(state.T_map_sensor, state.twist, -reference),
            pose_covariance(covariance, state.twist, -reference), state.twist,
            found.degenerate_directions};
  }

  /// The second scan: the speed may be anything, and the first one is still as skewed as it came.
  SweepMatcher::Found find_first_motion(const MotionBelief& prediction, double seconds) {
    const auto& points = sampler_.points();
    SweepMatcher::Found found;
    std::vector<MotionState> starts = starts_at_speed(start_, seconds + first_reference_);
    starts.push_back(prediction.state);
    Vector6d deskewed_with = Vector6d::Zero();
    const auto deskew_first = [&](const Vector6d& twist) {
      if (!first_has_times_ || is_same_motion(twist, deskewed_with)) return false;
      deskewed_with = twist;
      map_.clear();
      map_.insert(first_, {moved(start_, twist, first_reference_), twist});
      return true;
    };
    deskew_first(prediction.state.twist);
    found.match = matcher_.search(points, map_, prediction, starts);
    for (int round = 0; round < kStartRounds && deskew_first(found.match.state.twist); ++round) {
      found.match = matcher_.refine(points, map_, prediction, found.match.state);
    }
    found.degenerate_directions = degenerate_directions(found.match.pose_hessian);
    return found;
  }

  static void describe(const SweepMatcher::Found& found, FrontEndStatus& status) {
    status.converged = found.match.converged;
    status.iterations = found.match.iterations;
    status.fitness = found.match.fitness;
    status.inlier_fraction = found.match.inlier_fraction;
    status.overlap = found.match.overlap;
    status.rescued = found.rescued;
    status.degenerate_directions = found.degenerate_directions;
  }

  void accept(const SweepMatcher::Found& found, const MotionPrior& prior, FrontEndStatus& status) {
    const NdtMatch& match = found.match;
    if (one_place_ && found.degenerate_directions.empty()) {
      status.degenerate_directions = degenerate_directions(match.pose_hessian, kOnePlaceShare);
    }
    if (!status.degenerate_directions.empty() && status.state == TrackingState::kTracking) {
      status.state = TrackingState::kDegenerate;
    }
    if (status.degenerate_directions.empty() && prior.linear_velocity) {
      velocity_trust_.see(*prior.linear_velocity, match.state.twist.head<3>());
    }
    filter_.correct(match.state, match.information.inverse(),
                    projection_beside(found.degenerate_directions));
    covariance_ = reported_covariance(match);
    if (inserted_scans_ <= kYoungScans) covariance_ *= variance_of_young_map(match.overlap);
    judge_.learn(match);
    last_good_ = match.state.T_map_sensor;
    lost_time_ = 0.0;
    motion_known_ = true;
  }

  /// The filter weighs the points low, because neighbouring ones err together, and so holds itself
  /// for worse than it is. What is reported has the size of the errors of simulated drives.
  static Matrix12d reported_covariance(const NdtMatch& match) {
    const Matrix12d information =
        match.information + (kReportedWeight - 1.0) * match.points_information;
    return information.inverse();
  }

  /// The prediction, held to a measured velocity as firmly as it has deserved so far.
  MotionBelief trusting_velocity(const MotionPrior& prior) const {
    MotionFilter filter = filter_;
    if (prior.linear_velocity) {
      filter.measure_velocity(velocity_trust_.corrected(*prior.linear_velocity),
                              velocity_trust_.usual_sigma());
    }
    return filter.belief();
  }

  /// Lost: the prediction stands, ever slower, until a match is found or the map is given up.
  void hold(const Scan& scan, double seconds, TrackedScan& result) {
    first_scans_.end();
    filter_.slow_down(seconds, kHoldTime);
    covariance_ = filter_.covariance();
    lost_time_ += seconds;
    // A map of one scan at an unknown speed is soon left behind: the newer scan takes its place.
    const bool worth_waiting = motion_known_ && lost_time_ <= config_.max_lost_time;
    if (worth_waiting || sampler_.points().size() < kMinPoints) return;
    const Pose pose =
        moved(filter_.state().T_map_sensor, filter_.state().twist, -sampler_.reference());
    forget();
    begin(scan, pose, result.status);
    result.new_segment = true;
  }

  void keep(const Scan& scan, const std::vector<Eigen::Vector3d>& degenerate_directions) {
    const Pose T_inserted_now = inserted_.inverse() * filter_.state().T_map_sensor;
    if (inserted_scans_ >= kFirstScans && !kInsertionRule.reached(T_inserted_now, 0)) return;
    insert(scan);
    filter_.anchor(degenerate_directions);
  }

  void insert(const Scan& scan) {
    timer_.start("dense sampling");
    const SampledPoints& dense = sampler_.dense(scan);
    timer_.start("insertion");
    map_.insert(dense, filter_.state());
    first_scans_.set_inserted(dense);
    inserted_ = filter_.state().T_map_sensor;
    ++inserted_scans_;
    const double way = (inserted_.translation - start_.translation).norm();
    if (way > kOnePlace * map_.fine().resolution()) one_place_ = false;
    if (config_.calibrate_elevation && inserted_scans_ > kFirstScans) calibrate(dense);
  }

  void calibrate(const SampledPoints& dense) {
    timer_.start("calibration");
    elevation_.see(dense, filter_.state(), map_.fine().resolution());
    sampler_.set_elevation_shift(elevation_.applied());
  }

  void report(TrackedScan& result) {
    const double to_stamp = -sampler_.reference();
    result.T_odom_base = moved(filter_.state().T_map_sensor, filter_.state().twist, to_stamp);
    result.covariance = pose_covariance(covariance_, filter_.state().twist, to_stamp);
    result.twist = filter_.state().twist;
    result.motion_known = motion_known_;
    result.provisional = first_scans_.is_open();
    result.status.step_seconds = timer_.take();
  }

  const FrontEndConfig config_;
  SweepSampler sampler_;
  LocalMap map_;
  MotionFilter filter_;
  MatchJudge judge_;
  SweepMatcher matcher_;
  VelocityTrust velocity_trust_;
  ElevationCalibration elevation_;
  FirstScans first_scans_;
  StepTimer timer_;

  Matrix12d covariance_ = Matrix12d::Identity();  ///< as it is reported
  std::size_t scans_ = 0;
  Stamp stamp_ = 0;
  Pose start_;      ///< of the map's first scan, at its stamp
  Pose inserted_;   ///< of the scan last put into the map
  Pose last_good_;  ///< of the scan last matched
  int inserted_scans_ = 0;
  bool one_place_ = true;   ///< all of the map was made from about one place
  double lost_time_ = 0.0;  ///< s since the last match
  bool motion_known_ = false;
  SampledPoints first_;
  bool first_has_times_ = false;
  double first_reference_ = 0.0;
};

NdtTracker::NdtTracker(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
NdtTracker::~NdtTracker() = default;

TrackedScan NdtTracker::track(const Scan& scan, const MotionPrior& prior) {
  return impl_->track(scan, prior);
}

void NdtTracker::settle() { impl_->settle(); }

void NdtTracker::set_sensor_origin(const Eigen::Vector3d& p_base_sensor) {
  impl_->set_sensor_origin(p_base_sensor);
}

void NdtTracker::restart(const Pose& T_odom_base) { impl_->restart(T_odom_base); }

PointCloud NdtTracker::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
