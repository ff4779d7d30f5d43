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
      : odometry(config), uses_measured_start(config.odometry == OdometrySource::kLidar) {}

  /// A start pose given by the user has priority over the values of other sensors.
  void set_start(const MotionPrior& prior) {
    const bool is_measured = uses_measured_start && prior.T_odom_base_initial;
    base_frame.set_start(is_measured ? *prior.T_odom_base_initial : *start);
    start.reset();
  }

  void update_pose_covariance(const FrontEndResult& result) {
    if (newest_pose) {
      pose_covariance = compose_covariance(
          pose_covariance, newest_pose->inverse() * result.T_odom_base, result.covariance);
    }
    newest_pose = result.T_odom_base;
  }

  SensorOdometry odometry;
  BaseFrame base_frame;
  std::optional<Pose> start = Pose::Identity();  ///< T_odom_base, set until the first scan
  bool uses_measured_start;  ///< whether a start pose measured by other sensors is used
  std::optional<Pose> newest_pose;
  Covariance6 pose_covariance = Covariance6::Zero();  ///< of newest_pose
};

FrontEnd::FrontEnd(const FrontEndConfig& config) : impl_(std::make_unique<Impl>(config)) {
  const Eigen::Map<const Vector6d> given(config.initial_pose.data());
  if (!given.isZero(0.0)) set_initial_pose(pose_of(given));
}

FrontEnd::~FrontEnd() = default;

FrontEndResult FrontEnd::process(const Scan& scan, const MotionPrior& prior) {
  if (impl_->start) impl_->set_start(prior);
  const MotionPrior own_prior =
      impl_->base_frame.of_sensor(prior, impl_->odometry.angular_velocity());
  FrontEndResult result = impl_->base_frame.of_base(impl_->odometry.process(scan, own_prior));
  impl_->update_pose_covariance(result);
  return result;
}

std::vector<FrontEndResult> FrontEnd::finalize() {
  return impl_->base_frame.of_base(impl_->odometry.finalize());
}

void FrontEnd::set_sensor_pose(const Pose& T_base_sensor) {
  impl_->odometry.set_viewpoint_at_origin();
  impl_->base_frame.set_sensor_pose(T_base_sensor);
}

void FrontEnd::set_initial_pose(const Pose& T_odom_base) {
  if (impl_->odometry.has_begun()) {
    throw InputError("an initial pose after the first scan; give it before, or restart");
  }
  impl_->start = T_odom_base;
  impl_->uses_measured_start = false;
}

void FrontEnd::resume(KeyFrameIndex next_index, std::uint32_t next_segment,
                      const Pose& T_odom_base) {
  impl_->odometry.resume(next_index, next_segment);
  impl_->start = T_odom_base;
  impl_->uses_measured_start = false;
}

Covariance6 FrontEnd::pose_covariance() const { return impl_->pose_covariance; }

PointCloud FrontEnd::local_map() const {
  return impl_->base_frame.in_odom(impl_->odometry.local_map());
}

}  // namespace lidar_mapping::front_end
