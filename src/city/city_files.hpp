// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "city_graph.hpp"
#include "drive_pieces.hpp"
#include "pair_search.hpp"
#include "search_chunks.hpp"

// The files by which the jobs of a city pass on their results, as JSON (doc/city.md). Each appears
// only when it is complete. Numbers come back exactly. All functions throw FileError; reading
// throws InputError, which names the file, if it is damaged.
namespace lidar_mapping::city {

void write_pieces(const DrivePieces& drive, const std::filesystem::path& path);
DrivePieces read_pieces(const std::filesystem::path& path);

/// Writes a file for each chunk, ID.json, into a new folder.
void write_chunks(const std::vector<Chunk>& chunks, const std::filesystem::path& folder);
Chunk read_chunk(const std::filesystem::path& path);

void write_loops(const PairLoops& loops, const std::filesystem::path& path);
PairLoops read_loops(const std::filesystem::path& path);

void write_joined(const JoinedCity& city, const std::filesystem::path& path);

}  // namespace lidar_mapping::city
