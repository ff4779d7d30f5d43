// SPDX-License-Identifier: BSD-3-Clause
#include "ndt_tracker.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <Eigen/LU>

#include "lidar_mapping/front_end/step_timer.hpp"

#include "step_origin.hpp"
#include "degeneracy.hpp"
#include "elevation_calibration.hpp"
#include "false_standstill_recovery.hpp"
#include "gyro_validator.hpp"
#include "key_frame_rule.hpp"
#include "local_map.hpp"
#include "map_initialization.hpp"
#include "match_evidence.hpp"
#include "match_judge.hpp"
#include "measured_motion.hpp"
#include "motion_filter.hpp"
#include "reported_covariance.hpp"
#include "ring_spacing.hpp"
#include "step_belief.hpp"
#include "sweep_clock.hpp"
#include "sweep_matcher.hpp"
#include "sweep_sampler.hpp"
#include "unobserved_travel.hpp"

namespace lidar_mapping::front_end {
namespace {

using registration::MotionBelief;
using registration::NdtMatch;

/// A scan is inserted into the local map after this motion, so standing still adds nothing.
const KeyFrameRule kInsertionRule{2.0, 0.1, 0.0};
/// The first scans are always inserted, and outside of rooms together with points between their
/// rings: planes of single rings fit at any pitch of the vehicle, and it pitches when it starts to
/// move.
constexpr int kInitialScans = 3;
/// Scans with fewer points are not used.
constexpr std::size_t kMinPoints = 50;

/// Median range of the points (m) below which a scan counts as taken indoors, and the factor for
/// all voxel sizes indoors.
constexpr double kIndoorRange = 7.0;
constexpr double kIndoorVoxelScale = 0.5;

// Standard deviations of the motion before the second scan.
constexpr double kInitialSpeedSigma = 15.0;  // m/s
constexpr double kInitialRateSigma = 1.0;    // rad/s

/// While tracking is lost, the speed decreases to 1/e in this time.
constexpr double kCoastTimeConstant = 1.0;  // s

/// Along these directions the rings on the ground contain no information.
const std::vector<Eigen::Vector3d> kLevelDirections = {Eigen::Vector3d::UnitX(),
                                                       Eigen::Vector3d::UnitY()};

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
        initialization_(config.registration.neighbor_search) {}

  TrackedScan track(const Scan& scan, const MotionPrior& prior) {
    timer_.start("sampling");
    sampler_.sample(scan, scans_++);
    const double seconds = clock_.advance(scan.stamp, sampler_.reference(), sampler_.duration());
    since_claim_ += seconds;
    TrackedScan result;
    result.status.elevation_shift = elevation_.accepted_angle();
    result.elevation_shift = elevation_.applied_angle();
    if (map_.empty()) {
      start_map(scan, start_, result.status);
    } else {
      timer_.start("matching");
      match_scan(scan, seconds, prior, predict(seconds, prior), result);
    }
    timer_.start("ageing");
    map_.set_center(filter_.state().T_map_sensor.translation);
    set_result(result);
    return result;
  }

  bool accepts_gyro(const MotionPrior& prior) const { return gyro_.accepts(prior); }

  void set_viewpoint_at_origin() {
    sampler_.set_viewpoint_at_origin();
    viewpoint_known_ = true;
  }

  void restart() {
    reset_map();
    start_ = Pose::Identity();
  }

  void finalize() { initialization_.finalize(); }

  PointCloud local_map() const { return map_.cloud(); }

 private:
  void reset_map() {
    map_.clear();
    judge_.reset();
    doubt_.reset();
    elevation_.interrupt();
    initialization_.reset();
    false_standstill_.reset();
    unobserved_travel_.interrupt();
    lost_time_ = 0.0;
  }

  /// Starts a map with its first scan. The points are stored until the motion during the scan is
  /// known.
  void start_map(const Scan& scan, const Pose& T_odom_base, FrontEndStatus& status) {
    start_ = last_matched_pose_ = T_odom_base;
    // The pose is known at the stamp, but the filter's time is the middle of the sweep.
    filter_.reset(T_odom_base, kInitialSpeedSigma, kInitialRateSigma);
    filter_.predict(sampler_.reference());
    covariance_ = filter_.covariance();
    drift_variance_factor_ = 1.0;
    indoors_ = sampler_.median_range() <= kIndoorRange;
    map_.restart(voxel_size());
    ring_spacing_gate_ =
        RingSpacingGate(viewpoint_known_ ? ring_spacing(scan.cloud, Eigen::Vector3d::Zero()) : 0.0);
    if (sampler_.points().size() < kMinPoints) {
      status.state = TrackingState::kLost;
      return;
    }
    status.state = TrackingState::kTracking;
    status.converged = true;
    initialization_.start(T_odom_base);
    store_provisional(scan);
    insert(scan);
    initialization_.set_first_scan(sampler_.sample_dense(scan),
                                   indoors_ ? SampledPoints{} : sampler_.between_rings(),
                                   scan.cloud.has_times(), sampler_.reference());
  }

  /// Rooms need smaller voxels than streets; the first scan of a map decides which of them it is.
  double voxel_size() const {
    return indoors_ ? kIndoorVoxelScale * config_.voxel_size : config_.voxel_size;
  }

  Prediction predict(double seconds, const MotionPrior& prior) {
    gyro_.add(prior, seconds, sampler_.duration());
    const std::optional<MeasuredTurning> turning = gyro_.turning();
    previous_rotation_ = filter_.state().T_map_sensor.rotation;
    MotionFilter high_noise = filter_.with_high_process_noise();
    for (MotionFilter* filter : {&filter_, &high_noise}) filter->predict(seconds, turning);
    predicted_speed_covariance_ = velocity_covariance(filter_.covariance());
    for (MotionFilter* filter : {&filter_, &high_noise})
      measured_.apply(gyro_.remaining_prior(prior), *filter);
    high_noise_filter_ = high_noise;
    return {filter_.belief(), measured_.belief_with_velocity(prior, filter_), high_noise.belief()};
  }

  void match_scan(const Scan& scan, double seconds, const MotionPrior& prior,
                  const Prediction& prediction, TrackedScan& result) {
    const auto [found, prior_belief] = locate(seconds, prediction);
    set_match_status(found, result.status);
    set_degenerate_directions(found, result.status);
    result.status.evidence = collect_evidence(found, prior_belief, seconds);
    result.status.evidence.degenerate = result.status.degenerate_directions.empty() ? 0.0 : 1.0;
    result.status.state = judge_.judge(found.match, prior_belief);
    if (!is_possible(found.match, seconds)) result.status.state = TrackingState::kLost;
    const StepBelief belief = evaluate_step(result.status.evidence, EvidenceSource::kNdt);
    doubt_.apply(belief, result.status);
    if (result.status.state == TrackingState::kLost) {
      coast(scan, seconds, result);
      return;
    }
    if (initialization_.replaces_first_scan(belief)) {
      restart_from(scan, found.match, prior_belief, result.status);
      return;
    }
    if (!initialization_.motion_known()) {
      initialization_.set_motion(found.match);
      false_standstill_.insert(initialization_.first_points(),
                               initialization_.first_state(found.match.state.twist));
    }
    accept(found, prior, result.status);
    if (!claims_pose(result.status.state)) {
      covariance_ += doubt_covariance(found.match.state, prior_belief, result.status.probability);
    }
    update_unobserved_travel(found, prediction.for_unobserved, seconds);
    store_provisional(scan);
    if (result.status.state != TrackingState::kDegraded)
      update_map(scan, found.degenerate_directions);
    result.revisions = initialization_.rematch_first_scans(filter_, judge_, map_);
  }

  /// Evidence for and against the match as the end of a step from the last claimed pose.
  StepEvidence collect_evidence(const SweepMatcher::Found& found, const MotionBelief& prior_belief,
                                double seconds) const {
    const NdtMatch& match = found.match;
    const double to_stamp = -sampler_.reference();
    StepEvidence evidence = evidence_of(match, prior_belief);
    evidence.points = static_cast<double>(sampler_.points().size());
    evidence.rescued = found.rescued ? 1.0 : 0.0;
    if (initialization_.motion_known() && sampler_.duration() > 0.0) {
      const Pose coasted_pose = moved(last_matched_pose_, match.state.twist, lost_time_ + seconds);
      const Vector6d d = difference(coasted_pose, match.state.T_map_sensor);
      evidence.motion_change = d.head<3>().norm();
      evidence.motion_change_angle = d.tail<3>().norm();
    }
    set_step(claim_,
             {moved(match.state.T_map_sensor, match.state.twist, to_stamp),
              pose_covariance(reported_covariance(match), match.state.twist, to_stamp) +
                  filter_.acceleration_covariance(to_stamp),
              initialization_.has_few_scans() ? initial_drift_variance_factor(match) : 1.0},
             since_claim_, evidence);
    return evidence;
  }

  /// Uses the motion since the last match, not the motion during the sweep, which does not show a
  /// jump of the pose. In a map of one scan the motion is not known yet, so it cannot be checked.
  bool is_possible(const NdtMatch& match, double seconds) const {
    return !initialization_.motion_known() ||
           judge_.is_possible_motion(last_matched_pose_.inverse() * match.state.T_map_sensor,
                                     lost_time_ + seconds);
  }

  /// The match, and the belief before it.
  std::pair<SweepMatcher::Found, MotionBelief> locate(double seconds,
                                                      const Prediction& prediction) {
    matched_without_level_ = false;
    if (!initialization_.motion_known()) {
      return {initialization_.match_second_scan(sampler_.points(), prediction.nominal, seconds,
                                                matcher_, map_),
              prediction.high_noise};
    }
    if (false_standstill_.track(sampler_.sparse(), high_noise_filter_, filter_))
      return match_vertical_structure();
    SweepMatcher::Found found =
        matcher_.find(sampler_.points(), map_, judge_, prediction, {last_matched_pose_});
    if (false_standstill_.detect(sampler_.sparse(), found.match, seconds,
                                 initialization_.covers_single_place(), filter_)) {
      return match_vertical_structure();
    }
    return {std::move(found), prediction.high_noise};
  }

  /// Matches from the pose that the vertical structures gave the filter.
  std::pair<SweepMatcher::Found, MotionBelief> match_vertical_structure() {
    matched_without_level_ = true;
    initialization_.finalize();
    judge_.reset();
    const MotionBelief prior_belief = filter_.belief();
    return {matcher_.match_without(sampler_.points(), map_, prior_belief, kLevelDirections),
            prior_belief};
  }

  void store_provisional(const Scan& scan) {
    if (!initialization_.is_provisional()) return;
    initialization_.add({scan.stamp,
                         sampler_.reference(),
                         sampler_.points(),
                         filter_.state(),
                         filter_.covariance(),
                         {}});
  }

  static void set_match_status(const SweepMatcher::Found& found, FrontEndStatus& status) {
    status.converged = found.match.converged;
    status.iterations = found.match.iterations;
    status.fitness = found.match.fitness;
    status.inlier_fraction = found.match.inlier_fraction;
    status.overlap = found.match.overlap;
    status.rescued = found.rescued;
  }

  void set_degenerate_directions(const SweepMatcher::Found& found, FrontEndStatus& status) const {
    status.degenerate_directions = found.degenerate_directions;
    if (!initialization_.covers_single_place() || !found.degenerate_directions.empty()) return;
    status.degenerate_directions =
        degenerate_directions(found.match.pose_hessian, kSinglePlaceFraction);
  }

  void accept(const SweepMatcher::Found& found, const MotionPrior& prior, FrontEndStatus& status) {
    const NdtMatch& match = found.match;
    if (!status.degenerate_directions.empty() && claims_pose(status.state)) {
      status.state = TrackingState::kDegenerate;
    }
    if (!status.degenerate_directions.empty())
      ring_spacing_gate_.mark_open_field(match.state.T_map_sensor);
    if (status.degenerate_directions.empty()) measured_.update(prior, match.state.twist.head<3>());
    gyro_.update(previous_rotation_, filter_.forecast_state().T_map_sensor.rotation,
                 match.state.T_map_sensor.rotation);
    filter_.correct(match.state, match.information.inverse(),
                    projection_orthogonal_to(found.degenerate_directions));
    covariance_ = reported_covariance(match);
    drift_variance_factor_ =
        initialization_.has_few_scans() ? initial_drift_variance_factor(match) : 1.0;
    if (status.state != TrackingState::kDegraded) judge_.learn(match);
    last_matched_pose_ = match.state.T_map_sensor;
    lost_time_ = 0.0;
  }

  /// Updates the uncertainty of the distance travelled: along directions that the planes do not
  /// observe, only the believed speed is known. If vertical structures replace the rings, they
  /// observe the position.
  void update_unobserved_travel(const SweepMatcher::Found& found,
                                const MotionBelief& for_unobserved, double seconds) {
    if (found.degenerate_directions.empty() || matched_without_level_) {
      const Eigen::Matrix3d covariance = velocity_covariance(filter_.covariance());
      unobserved_travel_.add_observed(found.match.state.twist.head<3>().norm(), covariance.trace(),
                                      seconds);
      return;
    }
    const Eigen::Matrix3d measured = velocity_covariance(for_unobserved.information.inverse());
    double before = 0.0;
    double after = 0.0;
    for (const Eigen::Vector3d& d : found.degenerate_directions) {
      before += d.dot(predicted_speed_covariance_ * d);
      after += d.dot(measured * d);
    }
    unobserved_travel_.add_unobserved(std::max(0.0, 1.0 / after - 1.0 / before), seconds);
  }

  static Eigen::Matrix3d velocity_covariance(const Matrix12d& covariance) {
    return covariance.block<3, 3>(6, 6);
  }

  /// Tracking is lost: the pose follows the prediction with decreasing speed until a match is found
  /// or the map is discarded.
  void coast(const Scan& scan, double seconds, TrackedScan& result) {
    initialization_.finalize();
    unobserved_travel_.interrupt();
    filter_.slow_down(seconds, kCoastTimeConstant);
    covariance_ = filter_.covariance();
    drift_variance_factor_ = 1.0;
    lost_time_ += seconds;
    // At an unknown speed the vehicle soon leaves a map of one scan, so the newer scan replaces it.
    const bool keeps_map = initialization_.motion_known() && lost_time_ <= config_.max_lost_time;
    if (keeps_map || sampler_.points().size() < kMinPoints) return;
    const Pose pose =
        moved(filter_.state().T_map_sensor, filter_.state().twist, -sampler_.reference());
    reset_map();
    start_map(scan, pose, result.status);
    // The pose is still a prediction.
    result.status.state = TrackingState::kLost;
    result.new_segment = true;
  }

  /// Starts the map again with this scan, at its best match with the map of the first scan.
  void restart_from(const Scan& scan, const NdtMatch& match, const MotionBelief& prior_belief,
                    FrontEndStatus& status) {
    const double to_stamp = -sampler_.reference();
    const Matrix12d covariance = reported_covariance(match) +
                                 doubt_covariance(match.state, prior_belief, status.probability);
    reset_map();
    FrontEndStatus started;
    start_map(scan, moved(match.state.T_map_sensor, match.state.twist, to_stamp), started);
    initialization_.finalize();
    covariance_ = covariance;
  }

  void update_map(const Scan& scan, const std::vector<Eigen::Vector3d>& degenerate_directions) {
    const Pose T_insertion_now = last_insertion_pose_.inverse() * filter_.state().T_map_sensor;
    if (initialization_.inserted_scans() >= kInitialScans &&
        !kInsertionRule.reached(T_insertion_now, 0)) {
      timer_.start("calibration");
      elevation_.compare_pending();
      return;
    }
    insert(scan);
    filter_.anchor(degenerate_directions);
  }

  void insert(const Scan& scan) {
    timer_.start("dense sampling");
    const SampledPoints& dense = sampler_.sample_dense(scan);
    timer_.start("insertion");
    map_.set_ring_spacing(ring_spacing_gate_.spacing_at(filter_.state().T_map_sensor));
    map_.insert(dense, filter_.state());
    // The surfaces of a room are small, and many rings hit each of them: with these points, the
    // error of a recorded sensor of 16 beams that stands in a room is 15 mm instead of 5.
    if (!indoors_ && initialization_.inserted_scans() < kInitialScans) {
      map_.insert(sampler_.sample_between_rings(scan), filter_.state());
    }
    last_insertion_pose_ = filter_.state().T_map_sensor;
    initialization_.set_inserted(dense, last_insertion_pose_.translation, map_.fine().resolution());
    if (initialization_.motion_known()) false_standstill_.insert(dense, filter_.state());
    if (config_.calibrate_elevation && initialization_.inserted_scans() > kInitialScans)
      calibrate(dense);
  }

  void calibrate(const SampledPoints& dense) {
    timer_.start("calibration");
    elevation_.add_scan(dense, filter_.state(), map_.fine().resolution());
    sampler_.set_elevation_shift(elevation_.applied_angle());
  }

  void set_result(TrackedScan& result) {
    const double to_stamp = -sampler_.reference();
    const MotionState at_stamp = steadily_accelerated(filter_.state(), filter_.acceleration(),
                                                      sampler_.duration(), to_stamp);
    result.T_odom_base = at_stamp.T_map_sensor;
    result.acceleration = filter_.acceleration();
    result.covariance = pose_covariance(covariance_, filter_.state().twist, to_stamp) +
                        filter_.acceleration_covariance(to_stamp);
    result.drift_variance_factor = drift_variance_factor_;
    result.twist = at_stamp.twist;
    result.motion_known = initialization_.motion_known();
    result.provisional = initialization_.is_provisional();
    if (claims_pose(result.status.state) || result.new_segment) claim(result);
    result.status.map_points_dropped = map_.dropped_points();
    result.status.unobserved_stddev = unobserved_travel_.stddev();
    result.status.stamp_jitter = clock_.jitter();
    result.status.gyro_distrusted = gyro_.is_distrusted();
    result.status.step_seconds = timer_.take();
  }

  void claim(const TrackedScan& result) {
    claim_ = {result.T_odom_base, result.covariance, result.drift_variance_factor};
    since_claim_ = 0.0;
  }

  const FrontEndConfig config_;
  SweepSampler sampler_;
  SweepClock clock_;
  LocalMap map_;
  MotionFilter filter_;
  MotionFilter high_noise_filter_ = filter_;
  MatchJudge judge_;
  DoubtState doubt_;
  SweepMatcher matcher_;
  MeasuredMotion measured_;
  GyroValidator gyro_;
  /// rotation at the previous scan
  Eigen::Quaterniond previous_rotation_ = Eigen::Quaterniond::Identity();
  ElevationCalibration elevation_;
  MapInitialization initialization_;
  FalseStandstillRecovery false_standstill_;
  UnobservedTravel unobserved_travel_;
  StepTimer timer_;

  Eigen::Matrix3d predicted_speed_covariance_ =
      Eigen::Matrix3d::Zero();          ///< before velocity measurements are applied
  bool indoors_ = false;                ///< the map began indoors
  bool matched_without_level_ = false;  ///< the scan was matched without the horizontal directions
  Matrix12d covariance_ = Matrix12d::Identity();  ///< the reported covariance
  double drift_variance_factor_ = 1.0;
  bool viewpoint_known_ = false;
  RingSpacingGate ring_spacing_gate_;
  std::size_t scans_ = 0;
  Pose start_;                ///< start pose of a map, at the stamp of its first scan
  Pose last_insertion_pose_;  ///< pose of the scan last inserted into the map
  Pose last_matched_pose_;    ///< pose of the scan last matched
  double lost_time_ = 0.0;    ///< s since the last match
  PoseEstimate claim_;         ///< of the last scan with a claimed pose
  double since_claim_ = 0.0;  ///< s
};

NdtTracker::NdtTracker(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
NdtTracker::~NdtTracker() = default;

TrackedScan NdtTracker::track(const Scan& scan, const MotionPrior& prior) {
  return impl_->track(scan, prior);
}

bool NdtTracker::accepts_gyro(const MotionPrior& prior) const { return impl_->accepts_gyro(prior); }

void NdtTracker::finalize() { impl_->finalize(); }

void NdtTracker::set_viewpoint_at_origin() { impl_->set_viewpoint_at_origin(); }

void NdtTracker::restart() { impl_->restart(); }

PointCloud NdtTracker::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
