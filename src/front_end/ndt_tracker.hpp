// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "tracker.hpp"

namespace lidar_mapping::front_end {

/// The sequential NDT: estimates pose and twist of each sweep by one match against hashed voxel
/// maps. The maps grow with the drive, and voxels far away are removed (doc/front_end.md).
class NdtTracker : public Tracker {
 public:
  explicit NdtTracker(const FrontEndConfig& config);
  ~NdtTracker() override;

  TrackedScan track(const Scan& scan, const MotionPrior& prior) override;
  void set_viewpoint_at_origin() override;
  void restart() override;
  bool accepts_gyro(const MotionPrior& prior) const override;
  void finalize() override;
  PointCloud local_map() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::front_end
