// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::pipeline {

/// Parameters of all stages of the pipeline.
struct PipelineConfig {
  preprocessing::PreprocessingConfig preprocessing;     ///< Parameters of preprocessing.
  preprocessing::FloorDetectionConfig floor_detection;  ///< Parameters of floor detection.
  front_end::FrontEndConfig front_end;                  ///< Parameters of the odometry.
  loop_closing::LoopClosingConfig loop_closing;         ///< Parameters of loop closing.
  back_end::BackEndConfig back_end;                     ///< Parameters of the graph optimisation.
  /// Upper limit of threads; 1: all work is done in the caller's thread. The result does not depend
  /// on it.
  int threads = 2;
  /// When a session is resumed: repeat all of its drive instead of the last section only.
  bool replay_whole = false;
};

}  // namespace lidar_mapping::pipeline
