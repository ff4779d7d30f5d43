#include "lidar_mapping/front_end/front_end.hpp"

#include <chrono>
#include <string>

#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/front_end/deskew.hpp"
#include "lidar_mapping/front_end/key_frame_rule.hpp"
#include "lidar_mapping/front_end/scan_sampler.hpp"
#include "lidar_mapping/front_end/step_timer.hpp"
#include "lidar_mapping/front_end/tracker.hpp"

namespace lidar_mapping::front_end {
namespace {

/// An odometry from outside is trusted to this share of the way and of the angle, and to this much.
constexpr double kExternalError = 0.02;
constexpr double kExternalSigma = 0.005;       // m
constexpr double kExternalAngleSigma = 0.001;  // rad

// Two scans that see the same part of the map err together. As new parts come into sight, each
// standing on the poses before, errors part, and then add up: measured on simulated drives.
constexpr double kSharedView = 0.4;   // of the variance of two independent poses
constexpr double kNewViewWay = 1.2;   // m
constexpr double kNewViewTurn = 0.1;  // rad

double error_growth(const Pose& motion) {
  return kSharedView + motion.translation.norm() / kNewViewWay +
         rotation_angle(motion.rotation) / kNewViewTurn;
}

Covariance6 motion_covariance(const TrackedScan& from, const TrackedScan& to) {
  const Pose T_from_to = from.T_odom_base.inverse() * to.T_odom_base;
  return error_growth(T_from_to) * compose_covariance(from.covariance, T_from_to, to.covariance);
}

Covariance6 external_covariance(const TrackedScan& from, const TrackedScan& to) {
  const Pose T_from_to = from.T_odom_base.inverse() * to.T_odom_base;
  return diagonal_covariance(
      kExternalSigma + kExternalError * T_from_to.translation.norm(),
      kExternalAngleSigma + kExternalError * rotation_angle(T_from_to.rotation));
}

}  // namespace

class FrontEnd::Impl {
 public:
  explicit Impl(const FrontEndConfig& config)
      : config_(config),
        rule_{config.key_frame_distance, config.key_frame_angle, config.key_frame_interval} {
    if (config.odometry == OdometrySource::kLidar) tracker_ = make_tracker(config);
  }

  FrontEndResult process(const Scan& scan, const MotionPrior& prior) {
    check_stamp(scan.stamp);
    const TrackedScan tracked = tracker_ ? tracker_->track(scan, prior) : follow(scan, prior);
    if (tracked.new_segment) begin_segment();
    FrontEndResult result;
    result.stamp = scan.stamp;
    result.T_odom_base = tracked.T_odom_base;
    result.twist = tracked.twist;
    result.status = tracked.status;
    if (last_) result.covariance = covariance_since(*last_, tracked);
    timer_.start("key frame");
    if (key_frame_due(scan, tracked)) result.key_frame = make_key_frame(scan, tracked);
    for (auto& step : timer_.take()) result.status.step_seconds.push_back(std::move(step));
    for (const auto& step : result.status.step_seconds) result.status.seconds += step.second;
    last_ = tracked;
    last_stamp_ = scan.stamp;
    return result;
  }

  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base) {
    next_index_ = next_index;
    segment_ = next_segment;
    initial_ = T_odom_base;
    last_key_frame_.reset();
    last_.reset();
    if (tracker_) tracker_->restart(T_odom_base);
  }

  PointCloud local_map() const { return tracker_ ? tracker_->local_map() : PointCloud{}; }

 private:
  void check_stamp(Stamp stamp) const {
    if (!last_stamp_ || stamp > *last_stamp_) return;
    throw InputError("front_end: stamp " + std::to_string(stamp) + " ns does not come after " +
                     std::to_string(*last_stamp_) + " ns; drop scans that are out of order");
  }

  void begin_segment() {
    ++segment_;
    last_.reset();
    last_key_frame_.reset();
  }

  /// `odometry: external`.
  TrackedScan follow(const Scan& scan, const MotionPrior& prior) {
    if (!prior.T_external_base) {
      throw InputError("front_end: no external odometry for stamp " + std::to_string(scan.stamp) +
                       " ns; give MotionPrior::T_external_base or set odometry: lidar");
    }
    TrackedScan tracked;
    if (!T_odom_external_) T_odom_external_ = initial_ * prior.T_external_base->inverse();
    tracked.T_odom_base = *T_odom_external_ * *prior.T_external_base;
    tracked.status.converged = true;
    return tracked;
  }

  Covariance6 covariance_since(const TrackedScan& from, const TrackedScan& to) const {
    return tracker_ ? motion_covariance(from, to) : external_covariance(from, to);
  }

  bool key_frame_due(const Scan& scan, const TrackedScan& tracked) const {
    if (tracked.status.state == TrackingState::kLost) return false;
    // Skewed for good, it would skew what later closes on it.
    if (scan.cloud.has_times() && !tracked.motion_known) return false;
    return !last_key_frame_ ||
           rule_.reached(last_key_frame_->T_odom_base.inverse() * tracked.T_odom_base,
                         scan.stamp - key_frame_stamp_);
  }

  KeyFrame make_key_frame(const Scan& scan, const TrackedScan& tracked) {
    KeyFrame key_frame;
    key_frame.index = next_index_++;
    key_frame.segment = segment_;
    key_frame.stamp = scan.stamp;
    key_frame.T_odom_base = tracked.T_odom_base;
    if (last_key_frame_) key_frame.motion_covariance = covariance_since(*last_key_frame_, tracked);
    key_frame.degenerate_directions = tracked.status.degenerate_directions;
    PointCloud cloud = key_frame_cloud(scan.cloud, tracked);
    key_frame.cloud = std::make_shared<const PointCloud>(std::move(cloud));
    last_key_frame_ = tracked;
    key_frame_stamp_ = scan.stamp;
    return key_frame;
  }

  PointCloud key_frame_cloud(const PointCloud& cloud, const TrackedScan& tracked) {
    if (tracked.elevation_shift == 0.0) return thinned_and_deskewed(cloud, tracked.twist);
    PointCloud shifted = cloud;
    const ElevationShift shift(tracked.elevation_shift);
    for (Point& p : shifted.points) shift(p.x, p.y, p.z);
    return thinned_and_deskewed(shifted, tracked.twist);
  }

  PointCloud thinned_and_deskewed(const PointCloud& cloud, const Vector6d& twist) {
    if (config_.key_frame_cloud_resolution <= 0.0) return deskewed(cloud, twist, config_.threads);
    SamplingOptions options;
    options.resolution = config_.key_frame_cloud_resolution;
    return deskewed(cloud, sampler_.sample(cloud, options), twist);
  }

  FrontEndConfig config_;
  StepTimer timer_;
  ScanSampler sampler_{19};
  KeyFrameRule rule_;
  std::unique_ptr<Tracker> tracker_;
  Pose initial_;
  std::optional<Pose> T_odom_external_;
  std::optional<TrackedScan> last_;
  std::optional<Stamp> last_stamp_;
  std::optional<TrackedScan> last_key_frame_;
  Stamp key_frame_stamp_ = 0;
  KeyFrameIndex next_index_ = 0;
  std::uint32_t segment_ = 0;
};

FrontEnd::FrontEnd(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
FrontEnd::~FrontEnd() = default;

FrontEndResult FrontEnd::process(const Scan& scan, const MotionPrior& prior) {
  return impl_->process(scan, prior);
}

void FrontEnd::resume(KeyFrameIndex next_index, std::uint32_t next_segment,
                      const Pose& T_odom_base) {
  impl_->resume(next_index, next_segment, T_odom_base);
}

PointCloud FrontEnd::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
