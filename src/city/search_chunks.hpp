// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drive_pieces.hpp"

namespace lidar_mapping::city {

/// Key frames of a drive, both ends included.
struct KeyFrameRange {
  KeyFrameIndex first = 0;  ///< the first one
  KeyFrameIndex last = 0;   ///< the last one
};
/// True if the index lies in one of the ranges.
bool contains(const std::vector<KeyFrameRange>& ranges, KeyFrameIndex index);

/// One job of the loop search: stretches of two drives that may have seen the same places.
struct Chunk {
  std::string id;                       ///< unique, usable as the name of a file
  std::string a;                        ///< drive in which is searched
  std::string b;                        ///< drive whose key frames are searched for
  std::vector<KeyFrameRange> a_ranges;  ///< of drive a, increasing
  std::vector<KeyFrameRange> b_ranges;  ///< of drive b, increasing
  bool by_position = false;             ///< GNSS places pieces of both near each other
  bool by_appearance = false;           ///< pieces of both look alike
};

/// The chunks in which loops between the drives are searched, in the order of the drives. Pieces
/// are paired where their boxes lie near each other, and where they look alike; a pair of drives
/// appears in as many chunks as drive b has kilometres with partners.
std::vector<Chunk> find_chunks(const std::vector<DrivePieces>& drives);

}  // namespace lidar_mapping::city
