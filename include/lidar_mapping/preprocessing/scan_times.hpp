#pragma once

#include <string>

#include "lidar_mapping/common/point_cloud.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// First and last time of the points, s relative to the scan's stamp; both 0 without times.
struct TimeSpan {
  double begin = 0.0;
  double end = 0.0;
};
TimeSpan time_span(const PointCloud& cloud);

struct SettledTimes {
  TimeSpan span;        ///< of the times that there are now
  std::string problem;  ///< a sentence where something is wrong
};

/// Makes the times of a scan what the rest of the stage takes them for: seconds relative to the
/// stamp (`absolute` ones are that already), or none if the scan counts as compensated. An
/// implausible span leaves the scan without times.
SettledTimes settle_times(PointCloud& cloud, bool absolute, const PreprocessingConfig& config);

}  // namespace lidar_mapping::preprocessing
