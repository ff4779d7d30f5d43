// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

#include "point_to_plane.hpp"

namespace lidar_mapping::registration {
class Registration;
}

namespace lidar_mapping::loop_closing {

/// Aligns scans with submaps by the method that the configuration names. Whatever the method, the
/// covariance is that of the point-to-plane residuals where the scan came to lie, so that loops are
/// weighed alike. One thread calls it.
class ScanAlignment {
 public:
  explicit ScanAlignment(const LoopClosingConfig& config);
  ~ScanAlignment();

  /// Points of `source` and `target` in m, each in the frame of its own key frame.
  Alignment align(const std::vector<Eigen::Vector3f>& source, const SurfaceCloud& target,
                  const Pose& T_target_source_guess);

 private:
  std::unique_ptr<registration::Registration> registration_;  ///< null for the own way
};

}  // namespace lidar_mapping::loop_closing
