// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <random>

namespace lidar_mapping::test {

/// Puts odd values into one to three cells of a session.db: numbers that are none or lie beyond
/// all bounds, texts and blobs of the wrong length or kind. Flipped bytes seldom do that in a file
/// that is mostly pages and keys.
void spoil_session(const std::filesystem::path& database, std::mt19937& engine);

}  // namespace lidar_mapping::test
