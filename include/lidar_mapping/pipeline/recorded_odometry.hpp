// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/pipeline/input.hpp"
#include "lidar_mapping/pipeline/pipeline_config.hpp"

namespace lidar_mapping::pipeline {

/// A scan of a recorded drive with its odometry.
struct OdometryScan {
  Scan scan;                                               ///< In base_link, deskewed to its stamp.
  front_end::FrontEndResult result;                        ///< Final odometry of the scan.
  Eigen::Vector3d p_base_lidar = Eigen::Vector3d::Zero();  ///< The LiDAR in base_link, m.
};

/// Preprocessing and front end in one process, without loops and graph: turns recorded sensor data
/// into scans with odometry (doc/pipeline.md). Each stage has a thread and a bounded queue, and so
/// has the receiver of the scans; the results are the same for any number of threads. One thread
/// calls it.
class RecordedOdometry {
 public:
  /// Takes the scans in their order; called from another thread unless config.threads is 1.
  using Forward = std::function<void(OdometryScan&&)>;

  /// Uses preprocessing, front_end and threads of `config`. `T_base` is called from another thread.
  RecordedOdometry(const PipelineConfig& config, preprocessing::ExtrinsicLookup T_base,
                   Forward forward);
  ~RecordedOdometry();

  /// Adds a datum; waits while the queues are full. Throws what `forward` threw.
  void add(Input input);
  /// Processes all data in the queues and forwards the last scans. Throws what `forward` threw.
  void finish();
  /// Messages about events and problems since the last call.
  std::vector<std::string> take_messages();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
