// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

// What reader and writer of binary pose graphs have in common; doc/back_end.md describes the
// format.

namespace lidar_mapping::pose_graph::binary_graph {

// The file consists of 64-bit words, little-endian; see doc/back_end.md.
using Word = std::uint64_t;

// "LMGRAPH" and a line feed, by the format: a transfer as text would change the last byte.
constexpr Word kMagic = 0x0a48504152474d4c;
constexpr Word kVersion = 1;  // by the format: of what follows the first two words
// Words before the nodes, by the format: magic, version, dimensions, numbers of nodes and edges.
constexpr std::size_t kHeaderWords = 5;

/// Numbers of a pose and of the upper triangle of its information, by the format.
inline std::size_t pose_words(bool planar) { return planar ? 3 : 7; }
inline std::size_t information_words(bool planar) { return planar ? 6 : 21; }
inline std::size_t node_words(bool planar) { return 1 + pose_words(planar); }
inline std::size_t edge_words(bool planar) {
  return 2 + pose_words(planar) + information_words(planar);
}

/// The word in the file's order of bytes, or back; nothing changes on most processors.
inline Word little_endian(Word word) {
  std::array<unsigned char, sizeof(Word)> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<unsigned char>(word >> (8 * i));
  }
  std::memcpy(&word, bytes.data(), sizeof word);
  return word;
}

/// FNV-1a (Fowler, Noll and Vo) of words instead of bytes, which is eight times as fast.
class Checksum {
 public:
  void add(Word word) { value_ = (value_ ^ word) * kPrime; }
  Word value() const { return value_; }

 private:
  static constexpr Word kPrime = 0x100000001b3;  // by the definition of FNV-1a for 64 bits
  Word value_ = 0xcbf29ce484222325;              // likewise
};

}  // namespace lidar_mapping::pose_graph::binary_graph
