// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidar_mapping {

/// The cells of a line of a table whose columns have commas between them (RFC 4180); one empty cell
/// of an empty line. A comma between quotes does not end a cell. The quotes do not belong to the
/// cell; two of them within quotes are one of its own. White space is kept, and the carriage return
/// at the end of a line of Windows.
std::vector<std::string> csv_cells(const std::string& line);

}  // namespace lidar_mapping
