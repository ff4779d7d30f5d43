// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace lidar_mapping {

/// Throws FileError if results cannot go into a new folder of this name, because something is there
/// that is no empty folder.
void check_new_folder(const std::filesystem::path& folder);

/// The absolute path of a folder, without a slash at its end and without "." and "..", so that its
/// last part is the name of the folder.
std::filesystem::path folder_path(const std::filesystem::path& folder);

/// A path beside a folder: its name behind a point, so that nobody takes it for a result, and
/// `ending`.
std::filesystem::path hidden_beside(const std::filesystem::path& folder, const std::string& ending);

}  // namespace lidar_mapping
