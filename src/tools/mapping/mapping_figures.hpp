// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/pipeline/pipeline.hpp"

#include "json.hpp"

namespace lidar_mapping::tools {

/// Times of a run of map_bag, s.
struct RunTimes {
  double reading = 0.0;   ///< processor time of reading
  double streamed = 0.0;  ///< until the last scan went in
  double mapped = 0.0;    ///< until the last optimisation
  double map = 0.0;       ///< for the map alone
  double whole = 0.0;
};

/// Times, counts (also of data that were left out) and memory of this process, after `driven`
/// seconds of driving.
json::Json mapping_figures(const pipeline::PipelineReport& report, double driven,
                           const RunTimes& times);

/// The same as text for the terminal.
std::string to_text(const json::Json& figures);

}  // namespace lidar_mapping::tools
