// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/front_end.hpp"

#include "lidar_mapping/common/errors.hpp"

#include "base_frame.hpp"
#include "sensor_odometry.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Converts x y z roll pitch yaw to a pose.
Pose pose_of(const Vector6d& values) {
  Pose pose;
  pose.translation = values.head<3>();
  pose.rotation = Eigen::AngleAxisd(values[5], Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(values[4], Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(values[3], Eigen::Vector3d::UnitX());
  return pose;
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
