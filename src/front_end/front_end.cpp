// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end.hpp"

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/step_timer.hpp"

#include "base_frame.hpp"
#include "cloud_fingerprint.hpp"
#include "coasting.hpp"
#include "covariance_inflation.hpp"
#include "isolated_point_filter.hpp"
#include "key_frame_rule.hpp"
#include "scan_sampler.hpp"
#include "step_origin.hpp"
#include "sweep_times.hpp"
#include "sweep_times_trial.hpp"
#include "tracker.hpp"
#include "vertical_ride_detector.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Errors of an external odometry: this fraction of the distance and of the angle, plus these
/// constants.
constexpr double kExternalError = 0.02;
constexpr double kExternalSigma = 0.005;       // m
constexpr double kExternalAngleSigma = 0.001;  // rad

Covariance6 external_covariance(const TrackedScan& from, const TrackedScan& to) {
  const Pose T_from_to = from.T_odom_base.inverse() * to.T_odom_base;
  return diagonal_covariance(
      kExternalSigma + kExternalError * T_from_to.translation.norm(),
      kExternalAngleSigma + kExternalError * rotation_angle(T_from_to.rotation));
}

/// A scan that is probably wrong becomes a key frame only if no better one follows within this
/// multiple of the usual distance.
constexpr double kDegradedKeyFrameFactor = 3.0;

/// Converts x y z roll pitch yaw to a pose.
Pose pose_of(const Vector6d& values) {
  Pose pose;
  pose.translation = values.head<3>();
  pose.rotation = Eigen::AngleAxisd(values[5], Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(values[4], Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(values[3], Eigen::Vector3d::UnitX());
  return pose;
}

PointCloud selected(const PointCloud& cloud, const std::vector<std::uint32_t>& indices) {
  PointCloud result;
  result.points.reserve(indices.size());
  for (const std::uint32_t i : indices) result.points.push_back(cloud.points[i]);
  if (!cloud.has_times()) return result;
  result.times.reserve(indices.size());
  for (const std::uint32_t i : indices) result.times.push_back(cloud.times[i]);
  return result;
}

/// Odometry of the frame that the scans are in, which is called base here; it begins at its first
/// pose.
class SensorOdometry {
 public:
  explicit SensorOdometry(const FrontEndConfig& config)
      : config_(config),
        rule_{config.key_frame_distance, config.key_frame_angle, config.key_frame_interval},
        degraded_rule_{kDegradedKeyFrameFactor * config.key_frame_distance,
                       kDegradedKeyFrameFactor * config.key_frame_angle,
                       kDegradedKeyFrameFactor * config.key_frame_interval} {
    if (config.odometry == OdometrySource::kLidar) tracker_ = make_tracker(config);
    if (tracker_ && config.check_point_times && is_sequential_ndt(config))
      times_trial_.emplace(config);
  }

  bool has_begun() const { return last_stamp_.has_value(); }
  /// The last angular velocity, rad/s.
  Eigen::Vector3d angular_velocity() const {
    return tracked_ ? Eigen::Vector3d(tracked_->twist.tail<3>()) : Eigen::Vector3d::Zero();
  }

  FrontEndResult process(const Scan& received, const MotionPrior& prior) {
    check_stamp(received.stamp);
    if (tracker_ && repeated_scans_.is_repeated(received.cloud) && tracked_)
      return coast(received.stamp);
    timer_.start("support");
    const bool by_gyro = keeps_gyro_correction(prior);
    const std::optional<Scan> changed = with_right_times(received, prior, by_gyro);
    const Scan& right = changed ? *changed : received;
    const Scan& scan = tracker_ ? isolated_point_filter_.without_isolated_points(right) : right;
    timer_.stop();
    TrackedScan tracked = tracker_ ? tracker_->track(scan, prior) : follow_external(scan, prior);
    std::vector<FrontEndResult> finalized;
    const bool times_change = try_other_times(scan, prior, by_gyro, tracked, finalized);
    check_vertical_ride(scan.stamp, prior, tracked);
    tracked_ = tracked;
    last_stamp_ = tracked_stamp_ = scan.stamp;
    timer_.start("key frame");
    if (!times_change && (tracked.new_segment || !tracked.provisional))
      finalized = finalize_provisional(tracked.revisions);
    if (tracked.new_segment) start_segment();
    FrontEndResult result = result_of(scan.stamp, tracked);
    result.finalized = std::move(finalized);
    if (tracked.provisional) {
      result.provisional = true;
      provisional_.push_back(
          {result, tracked, key_frame_points(scan.cloud, tracked.elevation_shift)});
    } else if (!times_change && key_frame_due(scan.stamp, scan.cloud, tracked)) {
      PointCloud points = key_frame_points(scan.cloud, tracked.elevation_shift);
      result.key_frame = make_key_frame(scan.stamp, tracked, std::move(points));
    }
    for (auto& step : timer_.take()) result.status.step_seconds.push_back(std::move(step));
    for (const auto& step : result.status.step_seconds) result.status.seconds += step.second;
    return result;
  }

  std::vector<FrontEndResult> finalize() {
    if (tracker_) tracker_->finalize();
    return finalize_provisional({});
  }

  void resume(KeyFrameIndex next_index, std::uint32_t next_segment) {
    next_index_ = next_index;
    segment_ = next_segment;
    T_first_external_.reset();
    last_key_frame_.reset();
    last_.reset();
    inflation_ = {};
    tracked_.reset();
    repeated_scans_.reset();
    ride_detector_.interrupt();
    provisional_.clear();
    if (tracker_) tracker_->restart();
    if (times_trial_) times_trial_->restart();
  }

  /// Tells that the scans are in the LiDAR's own frame.
  void set_viewpoint_at_origin() {
    if (tracker_) tracker_->set_viewpoint_at_origin();
    if (times_trial_) times_trial_->set_viewpoint_at_origin();
  }

  PointCloud local_map() const { return tracker_ ? tracker_->local_map() : PointCloud{}; }

 private:
  /// A provisional scan, and the points of its key frame, if it becomes one.
  struct ProvisionalScan {
    FrontEndResult result;
    TrackedScan tracked;
    PointCloud points;
  };

  /// True if the points stay corrected by the gyro.
  bool keeps_gyro_correction(const MotionPrior& prior) const {
    return prior.uneven_turning && times_ == SweepTimes::kAsGiven &&
           (!tracker_ || tracker_->accepts_gyro(prior));
  }

  /// The scan with the right times, and without the gyro's correction unless that is kept. Empty if
  /// nothing changes.
  std::optional<Scan> with_right_times(const Scan& scan, const MotionPrior& prior,
                                       bool keep_gyro_correction) const {
    const bool undo = prior.uneven_turning && !keep_gyro_correction;
    if (!undo && times_ == SweepTimes::kAsGiven) return std::nullopt;
    PointCloud cloud = undo ? put_back(*prior.uneven_turning, scan.cloud) : scan.cloud;
    cloud.times = sweep_times(cloud, times_, sweep_duration_);
    return Scan{scan.stamp, std::move(cloud)};
  }

  /// Continues the trial of other times, if it is not finished. If other times are right, their
  /// tracker takes over, and the function returns true; the scan itself still has the wrong times.
  bool try_other_times(const Scan& scan, const MotionPrior& prior, bool is_gyro_corrected,
                       TrackedScan& tracked, std::vector<FrontEndResult>& finalized) {
    tracked.status.sweep_times = times_;
    if (!times_trial_) return false;
    timer_.start("point times");
    std::optional<SweepTimesTrial::Successor> successor =
        is_gyro_corrected
            ? times_trial_->add({scan.stamp, put_back(*prior.uneven_turning, scan.cloud)}, prior,
                                tracked)
            : times_trial_->add(scan, prior, tracked);
    if (times_trial_->is_finished()) times_trial_.reset();
    timer_.stop();
    if (!successor) return false;
    finalized = finalize();
    tracker_ = std::move(successor->tracker);
    times_ = successor->times;
    sweep_duration_ = successor->duration;
    tracked = std::move(successor->tracked);
    tracked.status.sweep_times = times_;
    return true;
  }

  /// During a vertical ride that the points do not show, the vertical direction is unobserved, like
  /// the axis of a tunnel.
  void check_vertical_ride(Stamp stamp, const MotionPrior& prior, TrackedScan& tracked) {
    FrontEndStatus& status = tracked.status;
    const bool is_connected =
        last_stamp_ && !tracked.new_segment && status.state != TrackingState::kLost;
    if (!is_connected) ride_detector_.interrupt();
    const double seconds = last_stamp_ ? to_seconds(stamp - *last_stamp_) : 0.0;
    const bool adjoins = prior.felt && last_stamp_ == prior.felt->since;
    ride_detector_.add(tracked.T_odom_base, seconds, adjoins ? prior.felt : std::nullopt);
    status.unseen_way = ride_detector_.distance();
    status.unobserved_stddev = std::hypot(status.unobserved_stddev, ride_detector_.distance());
    if (!ride_detector_.is_riding()) return;
    status.degenerate_directions.push_back(tracked.T_odom_base.rotation.conjugate() *
                                           ride_detector_.up());
    if (claims_pose(status.state)) status.state = TrackingState::kDegenerate;
  }

  void check_stamp(Stamp stamp) const {
    if (!last_stamp_ || stamp > *last_stamp_) return;
    throw InputError("front_end: stamp " + std::to_string(stamp) + " ns does not come after " +
                     std::to_string(*last_stamp_) + " ns; drop scans that are out of order");
  }

  /// A repeated scan is not matched: it would fit at the last pose.
  FrontEndResult coast(Stamp stamp) {
    std::vector<FrontEndResult> finalized = finalize();
    ride_detector_.interrupt();
    last_stamp_ = stamp;
    FrontEndResult result =
        result_of(stamp, coasted(*tracked_, to_seconds(stamp - tracked_stamp_)));
    result.finalized = std::move(finalized);
    return result;
  }

  FrontEndResult result_of(Stamp stamp, const TrackedScan& tracked) {
    FrontEndResult result;
    result.stamp = stamp;
    result.segment = segment_;
    result.T_odom_base = tracked.T_odom_base;
    result.twist = tracked.twist;
    result.acceleration = tracked.acceleration;
    result.status = tracked.status;
    if (last_) add_step(*last_, tracked, result.covariance);
    last_ = tracked;
    return result;
  }

  void add_step(const TrackedScan& from, const TrackedScan& to, Covariance6& covariance) {
    covariance = covariance_since(from, to);
    if (is_doubtful(to.status)) covariance += expected_error_covariance(to.status);
    inflation_.add_step(from.T_odom_base.inverse() * to.T_odom_base, to.status);
  }

  std::vector<FrontEndResult> finalize_provisional(const std::vector<Revision>& revisions) {
    std::vector<FrontEndResult> finalized;
    if (!provisional_.empty()) {
      // The steps of these scans are added again.
      last_.reset();
      inflation_ = {};
    }
    for (std::size_t i = 0; i < provisional_.size(); ++i) {
      if (i < revisions.size()) revise(provisional_[i].tracked, revisions[i]);
      finalized.push_back(finalized_scan(std::move(provisional_[i])));
    }
    provisional_.clear();
    return finalized;
  }

  static void revise(TrackedScan& tracked, const Revision& revision) {
    tracked.T_odom_base = revision.T_odom_base;
    tracked.covariance = revision.covariance;
    tracked.drift_variance_factor = revision.drift_variance_factor;
    tracked.twist = revision.twist;
    tracked.acceleration = revision.acceleration;
    tracked.status.degenerate_directions = revision.degenerate_directions;
    tracked.motion_known = true;
  }

  FrontEndResult finalized_scan(ProvisionalScan provisional) {
    FrontEndResult result = result_of(provisional.result.stamp, provisional.tracked);
    result.status.step_seconds = provisional.result.status.step_seconds;
    result.status.seconds = provisional.result.status.seconds;
    if (key_frame_due(result.stamp, provisional.points, provisional.tracked)) {
      result.key_frame =
          make_key_frame(result.stamp, provisional.tracked, std::move(provisional.points));
    }
    return result;
  }

  void start_segment() {
    ++segment_;
    last_.reset();
    last_key_frame_.reset();
    inflation_ = {};
  }

  /// Pose by `odometry: external`.
  TrackedScan follow_external(const Scan& scan, const MotionPrior& prior) {
    if (!prior.T_external_base) {
      throw InputError("front_end: no external odometry for stamp " + std::to_string(scan.stamp) +
                       " ns; give MotionPrior::T_external_base or set odometry: lidar");
    }
    TrackedScan tracked;
    if (!T_first_external_) T_first_external_ = prior.T_external_base->inverse();
    tracked.T_odom_base = *T_first_external_ * *prior.T_external_base;
    tracked.status.converged = true;
    return tracked;
  }

  Covariance6 covariance_since(const TrackedScan& from, const TrackedScan& to) const {
    return tracker_ ? step_covariance(estimate_of(from), estimate_of(to))
                    : external_covariance(from, to);
  }

  bool key_frame_due(Stamp stamp, const PointCloud& cloud, const TrackedScan& tracked) const {
    if (tracked.status.state == TrackingState::kLost) return false;
    // The distortion of such a key frame would be permanent, and would disturb every loop to it.
    if (cloud.has_times() && !tracked.motion_known) return false;
    const KeyFrameRule& rule =
        tracked.status.state == TrackingState::kDegraded ? degraded_rule_ : rule_;
    return !last_key_frame_ ||
           rule.reached(last_key_frame_->T_odom_base.inverse() * tracked.T_odom_base,
                        stamp - key_frame_stamp_);
  }

  /// `points` is the result of key_frame_points().
  KeyFrame make_key_frame(Stamp stamp, const TrackedScan& tracked, PointCloud points) {
    KeyFrame key_frame;
    key_frame.index = next_index_++;
    key_frame.segment = segment_;
    key_frame.stamp = stamp;
    key_frame.T_odom_base = tracked.T_odom_base;
    if (last_key_frame_) {
      key_frame.motion_covariance = covariance_since(*last_key_frame_, tracked);
      inflation_.apply_to(key_frame);
    }
    inflation_ = {};
    key_frame.degenerate_directions = tracked.status.degenerate_directions;
    key_frame.cloud = std::make_shared<const PointCloud>(
        deskewed(std::move(points), tracked.twist, tracked.acceleration, config_.threads));
    last_key_frame_ = tracked;
    key_frame_stamp_ = stamp;
    return key_frame;
  }

  /// Points for a key frame before deskewing: thinned out, and rotated upwards by
  /// `elevation_shift`.
  PointCloud key_frame_points(const PointCloud& cloud, double elevation_shift) {
    PointCloud points = thinned(cloud);
    if (elevation_shift == 0.0) return points;
    const ElevationShift shift(elevation_shift);
    for (Point& p : points.points) shift(p.x, p.y, p.z);
    return points;
  }

  PointCloud thinned(const PointCloud& cloud) {
    if (config_.key_frame_cloud_resolution <= 0.0) return cloud;
    SamplingOptions options;
    options.resolution = config_.key_frame_cloud_resolution;
    return selected(cloud, sampler_.sample(cloud, options));
  }

  FrontEndConfig config_;
  StepTimer timer_;
  ScanSampler sampler_{19};
  KeyFrameRule rule_;
  KeyFrameRule degraded_rule_;
  RepeatedScans repeated_scans_;
  IsolatedPointFilter isolated_point_filter_;
  std::unique_ptr<Tracker> tracker_;
  std::optional<SweepTimesTrial> times_trial_;  ///< empty if finished, or if there is none
  SweepTimes times_ = SweepTimes::kAsGiven;
  double sweep_duration_ = 0.0;  ///< of a sweep whose points have no times, s
  std::optional<Pose> T_first_external_;
  std::vector<ProvisionalScan> provisional_;
  std::optional<TrackedScan> last_;
  VerticalRideDetector ride_detector_;
  std::optional<Stamp> last_stamp_;
  std::optional<TrackedScan> tracked_;  ///< the last scan that was given to the tracker
  Stamp tracked_stamp_ = 0;
  std::optional<TrackedScan> last_key_frame_;
  CovarianceInflation inflation_;  ///< of the motion since then
  Stamp key_frame_stamp_ = 0;
  KeyFrameIndex next_index_ = 0;
  std::uint32_t segment_ = 0;
};

}  // namespace

/// The odometry in the scans' own frame, and the conversion to base_link.
class FrontEnd::Impl {
 public:
  explicit Impl(const FrontEndConfig& config)
      : odometry_(config), uses_measured_start_(config.odometry == OdometrySource::kLidar) {
    const Eigen::Map<const Vector6d> given(config.initial_pose.data());
    if (!given.isZero(0.0)) set_initial_pose(pose_of(given));
  }

  void set_initial_pose(const Pose& T_odom_base) {
    if (odometry_.has_begun()) {
      throw InputError("an initial pose after the first scan; give it before, or start anew");
    }
    start_ = T_odom_base;
    uses_measured_start_ = false;
  }

  void set_sensor_pose(const Pose& T_base_sensor) {
    odometry_.set_viewpoint_at_origin();
    base_frame_.set_sensor_pose(T_base_sensor);
  }

  FrontEndResult process(const Scan& scan, const MotionPrior& prior) {
    if (start_) set_start(prior);
    const MotionPrior own_prior = base_frame_.of_sensor(prior, odometry_.angular_velocity());
    return base_frame_.of_base(odometry_.process(scan, own_prior));
  }

  std::vector<FrontEndResult> finalize() { return base_frame_.of_base(odometry_.finalize()); }

  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base) {
    odometry_.resume(next_index, next_segment);
    start_ = T_odom_base;
  }

  PointCloud local_map() const { return base_frame_.in_odom(odometry_.local_map()); }

 private:
  /// A start pose given by the user has priority over the values of other sensors.
  void set_start(const MotionPrior& prior) {
    const bool uses_measured_start = uses_measured_start_ && prior.T_odom_base_initial;
    base_frame_.set_start(uses_measured_start ? *prior.T_odom_base_initial : *start_);
    start_.reset();
  }

  SensorOdometry odometry_;
  BaseFrame base_frame_;
  std::optional<Pose> start_ = Pose::Identity();  ///< T_odom_base, set until the first scan
  bool uses_measured_start_;  ///< whether a start pose measured by other sensors is used
};

FrontEnd::FrontEnd(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
FrontEnd::~FrontEnd() = default;

FrontEndResult FrontEnd::process(const Scan& scan, const MotionPrior& prior) {
  return impl_->process(scan, prior);
}

std::vector<FrontEndResult> FrontEnd::finalize() { return impl_->finalize(); }

void FrontEnd::set_sensor_pose(const Pose& T_base_sensor) { impl_->set_sensor_pose(T_base_sensor); }

void FrontEnd::set_initial_pose(const Pose& T_odom_base) { impl_->set_initial_pose(T_odom_base); }

void FrontEnd::resume(KeyFrameIndex next_index, std::uint32_t next_segment,
                      const Pose& T_odom_base) {
  impl_->resume(next_index, next_segment, T_odom_base);
}

PointCloud FrontEnd::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
