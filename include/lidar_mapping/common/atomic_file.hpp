// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

namespace lidar_mapping {

/// Calls `write` with the name of a temporary file beside `path` (hidden, ending in .part), brings
/// what it wrote to the disk and renames it to `path`: a reader sees the old file or the new one,
/// never half of one, also after a kill or a power failure. Missing folders are made. A device or
/// pipe, such as /dev/stdout, is written itself, for it must not be replaced by a file. Throws
/// FileError, and an Error of `write` as it is; then `path` is as it was and the temporary file is
/// gone.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// write_atomically() with what `write` puts into the stream of the file. Throws FileError.
void write_stream_atomically(const std::filesystem::path& path,
                             const std::function<void(std::ostream& file)>& write);

/// write_atomically() with a text. Throws FileError.
void write_text_atomically(const std::filesystem::path& path, const std::string& text);

}  // namespace lidar_mapping
