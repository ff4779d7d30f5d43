#pragma once

#include <memory>

#include "lidar_mapping/front_end/tracker.hpp"

namespace lidar_mapping::front_end {

/// The sequential NDT: pose and twist of each sweep from one match against hashed voxel maps that
/// grow with the drive and forget what is far away (doc/front_end.md).
class NdtTracker : public Tracker {
 public:
  explicit NdtTracker(const FrontEndConfig& config);
  ~NdtTracker() override;

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  void set_sensor_origin(const Eigen::Vector3d& p_base_sensor) override;
  void restart(const Pose& T_odom_base) override;
  bool believes_gyro(const MotionPrior& prior) const override;
  void settle() override;
  PointCloud local_map() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
