// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace lidar_mapping::test {

/// A kind of file that the package reads.
struct ReaderKind {
  std::string name;
  /// Writes whole examples into a folder.
  std::function<void(const std::filesystem::path& folder)> write;
  /// Reads what is in a folder, as the commands do. Throws what they would report, and
  /// std::runtime_error if nonsense was taken.
  std::function<void(const std::filesystem::path& folder)> read;
  /// Damages a file where that takes more than changed bytes; none: mutated() does it.
  std::function<void(const std::filesystem::path& file, std::mt19937& engine)> spoil = {};
  /// Part of the names of the files that are spoilt; all if empty.
  std::string spoilt = {};
};

const std::vector<ReaderKind>& reader_kinds();

/// The files of a kind below the folder that it wrote, in a fixed order.
std::vector<std::filesystem::path> files_to_spoil(const ReaderKind& kind,
                                                  const std::filesystem::path& folder);

}  // namespace lidar_mapping::test
