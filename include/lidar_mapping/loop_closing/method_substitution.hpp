// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// A sentence that names the method in use, if the configured name is that of another system; else
/// empty.
std::string describe_substitution(const LoopMethod& method);

}  // namespace lidar_mapping::loop_closing
