// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace lidar_mapping {

/// The absolute path of `text`. A leading `~` or `~/` is the home folder, because no shell expands
/// it in a text that comes through a service or a parameter; a relative path begins at the present
/// working directory. An empty text stays empty. Throws InputError for another user's home
/// (`~name`) and where no home folder is known.
std::filesystem::path expanded_path(const std::string& text);

}  // namespace lidar_mapping
