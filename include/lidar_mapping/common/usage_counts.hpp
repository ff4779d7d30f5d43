// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidar_mapping {

/// Numbers of the loops and GNSS positions of a drive that its pose graph uses and does not use.
struct UsageCounts {
  std::size_t loops_used = 0;     ///< number of loops that the graph uses
  std::size_t loops_refused = 0;  ///< number of loops that contradict the graph or were refused
  std::size_t gnss_used = 0;      ///< number of GNSS positions that the graph uses
  /// Number of GNSS positions that contradict the graph, are too uncertain or are not finite.
  std::size_t gnss_refused = 0;
};

}  // namespace lidar_mapping
