// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

#include "matching/point_to_plane.hpp"

namespace lidar_mapping::registration {
class Registration;
}

namespace lidar_mapping::loop_closing {

/// Aligns scans with submaps by the configured method. For all methods, the covariance is computed
/// from the point-to-plane residuals at the result, so that the loops of all methods are weighted
/// alike. The class must be called from one thread.
class ScanAlignment {
 public:
  explicit ScanAlignment(const LoopClosingConfig& config);
  ~ScanAlignment();

  /// Registers `source` to `target`; the points are in m, each in the frame of its key frame.
  Alignment align(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                  const Pose& T_target_source_guess);

 private:
  /// Null for the point-to-plane method of this stage.
  std::unique_ptr<registration::Registration> registration_;
};

}  // namespace lidar_mapping::loop_closing
