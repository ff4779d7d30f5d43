// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <string>

namespace lidar_mapping::test {

/// The bytes with one to six things wrong: bits flipped, bytes or numbers overwritten, parts cut
/// out, repeated or moved, lines swapped, repeated or lost, the end cut off, numbers of a text put
/// in the place of others (nan, inf, -1, 1e308 ...).
std::string mutated(std::string bytes, std::mt19937& engine);

}  // namespace lidar_mapping::test
