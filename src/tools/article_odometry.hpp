// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::tools {

/// Odometry as the articles on lidar_localization describe it, made of PCL's parts: the base line
/// of odometry_benchmark. A window of 20 key frames, two metres apart by Manhattan distance, is
/// joined anew at each of them, thinned out to 0.6 m from the tenth on, and given to PCL's NDT as
/// its target; each scan, thinned out to 1.3 m, is matched from where the last step, repeated,
/// would have led. Nothing is judged, and poses are float matrices. The transformation epsilon has
/// the meaning of the articles, a length: PCL 1.13 would stop after a step with theirs.
class ArticleOdometry {
 public:
  ArticleOdometry();
  ~ArticleOdometry();

  /// Pose and times of the steps; the other fields stay as they are by default.
  front_end::FrontEndResult process(const Scan& scan);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::tools
