// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/scan_record.hpp"

namespace lidar_mapping::pipeline {

session::ScanRecord record_of(const front_end::FrontEndResult& result) {
  session::ScanRecord record;
  record.stamp = result.stamp;
  record.state = result.status.repeated ? "repeated" : front_end::to_string(result.status.state);
  record.fitness = result.status.fitness;
  record.overlap = result.status.overlap;
  record.unobserved_stddev = result.status.unobserved_stddev;
  record.elevation_shift = result.status.elevation_shift;
  record.probability = result.status.probability;
  return record;
}

}  // namespace lidar_mapping::pipeline
