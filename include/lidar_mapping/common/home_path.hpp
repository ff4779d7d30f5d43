// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace lidar_mapping {

/// The absolute path that a person means by `text`: a `~` or `~/` at its beginning is the home
/// folder, which no shell has put there where the text came through a service or a parameter; what
/// is relative is so to the present working directory. An empty text stays empty. Throws InputError
/// for another user's home (`~name`) and where no home folder is known.
std::filesystem::path path_of_person(const std::string& text);

}  // namespace lidar_mapping
