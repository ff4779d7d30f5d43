// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>

namespace lidar_mapping::map {

/// Calls `write` with a temporary folder beside `directory` (hidden, ending in .part) and renames
/// it to `directory` when it returns: the folder appears completely or not at all, and an older one
/// is replaced. An older one must hold the file `mark`, which shows that it is of the same kind;
/// `content` names the kind in the error. An older one that a kill has left aside (hidden, ending
/// in .old) is put back first. Throws FileError, and what `write` throws; nothing is left then.
void write_whole_folder(const std::filesystem::path& directory, const char* mark,
                        const char* content,
                        const std::function<void(const std::filesystem::path& folder)>& write);

}  // namespace lidar_mapping::map
