// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::pipeline {

/// Parameters of all stages that are put together.
struct PipelineConfig {
  preprocessing::PreprocessingConfig preprocessing;
  preprocessing::FloorDetectionConfig floor_detection;
  front_end::FrontEndConfig front_end;
  loop_closing::LoopClosingConfig loop_closing;
  back_end::BackEndConfig back_end;
  /// At most so many threads; 1 does everything in the caller's. The result is the same.
  int threads = 2;
  /// A session that is gone on with: drive all of it once more, not the last stretch alone.
  bool replay_whole = false;
};

}  // namespace lidar_mapping::pipeline
