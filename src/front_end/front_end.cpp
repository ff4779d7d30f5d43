// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end.hpp"

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/rotations.hpp"

#include "base_frame.hpp"
#include "sensor_odometry.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Converts x y z roll pitch yaw to a pose.
Pose pose_of(const Vector6d& values) {
  return {rotation_from_rpy(values[3], values[4], values[5]), values.head<3>()};
}

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
      throw InputError("an initial pose after the first scan; give it before, or restart");
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
    FrontEndResult result = base_frame_.of_base(odometry_.process(scan, own_prior));
    update_pose_covariance(result);
    return result;
  }

  const Covariance6& pose_covariance() const { return pose_covariance_; }

  std::vector<FrontEndResult> finalize() { return base_frame_.of_base(odometry_.finalize()); }

  void resume(KeyFrameIndex next_index, std::uint32_t next_segment, const Pose& T_odom_base) {
    odometry_.resume(next_index, next_segment);
    start_ = T_odom_base;
    uses_measured_start_ = false;
  }

  PointCloud local_map() const { return base_frame_.in_odom(odometry_.local_map()); }

 private:
  /// A start pose given by the user has priority over the values of other sensors.
  void set_start(const MotionPrior& prior) {
    const bool uses_measured_start = uses_measured_start_ && prior.T_odom_base_initial;
    base_frame_.set_start(uses_measured_start ? *prior.T_odom_base_initial : *start_);
    start_.reset();
  }

  void update_pose_covariance(const FrontEndResult& result) {
    if (newest_pose_) {
      pose_covariance_ = compose_covariance(
          pose_covariance_, newest_pose_->inverse() * result.T_odom_base, result.covariance);
    }
    newest_pose_ = result.T_odom_base;
  }

  SensorOdometry odometry_;
  BaseFrame base_frame_;
  std::optional<Pose> start_ = Pose::Identity();  ///< T_odom_base, set until the first scan
  bool uses_measured_start_;  ///< whether a start pose measured by other sensors is used
  std::optional<Pose> newest_pose_;
  Covariance6 pose_covariance_ = Covariance6::Zero();  ///< of newest_pose_
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

Covariance6 FrontEnd::pose_covariance() const { return impl_->pose_covariance(); }

PointCloud FrontEnd::local_map() const { return impl_->local_map(); }

}  // namespace lidar_mapping::front_end
