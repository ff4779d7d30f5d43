// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "json.hpp"

namespace lidar_mapping::report {

/// Place of a part of examination_figures() in words: "key frame 12 at 3.0, 4.0".
std::string place_words(const json::Json& part);

/// The sections of examination_figures() that were passed, with the least agreement first.
std::vector<json::Json> passed_sections(const json::Json& figures);

/// Place of such a section in words: "key frames 10 to 14 at 3.0, 4.0".
std::string section_words(const json::Json& section);

}  // namespace lidar_mapping::report
