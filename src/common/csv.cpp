// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/csv.hpp"

#include <cstddef>

namespace lidar_mapping {

std::vector<std::string> csv_cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line.compare(i, 2, "\"\"") == 0 && is_quoted) {
      cells.back() += '"';
      ++i;
    } else if (line[i] == '"') {
      is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

}  // namespace lidar_mapping
