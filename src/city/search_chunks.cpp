// SPDX-License-Identifier: BSD-3-Clause
#include "search_chunks.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::city {

namespace {

// m between two boxes at which loops may be found: detect_area (10 m) and the largest errors of
// reflected fixes (30 m), as in candidate_generator.cpp.
constexpr double kMargin = 40.0;
// Most similar places of other drives that are noted for each place. Chosen: as many drives may
// pass one place and all be found.
constexpr std::size_t kNearestPlaces = 5;
// Places whose keys are further apart are different ones. Measured on a simulated town with two
// sensors (223 places of 8 drives): revisits have 0.5 to 2.0 (one 2.07), the nearest of other
// places 2.07 and more.
constexpr double kMaxDistance = 2.0;
// Places of two drives that have to look alike before loops are searched. Chosen: one or two may do
// so by chance.
constexpr std::size_t kMinAlikePlaces = 3;
// Pieces of drive b in a chunk. Chosen: about a kilometre, some minutes of work.
constexpr std::size_t kMaxPieces = 10;
// Pieces to either side that are searched, too: unconnected drives are joined only by matches that
// agree over 100 m (unanchored_path_length). By geometry, of two pieces one would do; chosen: one
// more.
constexpr std::size_t kNeighbours = 2;

struct PieceId {
  std::size_t drive;
  std::size_t piece;
  bool operator<(const PieceId& other) const {
    return std::tie(drive, piece) < std::tie(other.drive, other.piece);
  }
};

/// Pieces of two drives that may have seen the same places.
struct PairedPieces {
  std::set<std::pair<std::size_t, std::size_t>> by_position;    ///< piece of a, piece of b
  std::set<std::pair<std::size_t, std::size_t>> by_appearance;  ///< the same
  std::size_t alike_places = 0;
};
using PairedDrives = std::map<std::pair<std::size_t, std::size_t>, PairedPieces>;

PairedPieces& pair_of(PairedDrives& pairs, PieceId& a, PieceId& b) {
  if (b.drive < a.drive) std::swap(a, b);
  return pairs[{a.drive, b.drive}];
}

/// Boxes within kMargin, by a sweep along one axis.
void pair_by_position(const std::vector<DrivePieces>& drives, PairedDrives& pairs) {
  std::vector<std::pair<Eigen::AlignedBox3d, PieceId>> boxes;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    for (std::size_t p = 0; p < drives[d].pieces.size(); ++p) {
      if (const auto& box = drives[d].pieces[p].box) boxes.push_back({*box, {d, p}});
    }
  }
  std::stable_sort(boxes.begin(), boxes.end(), [](const auto& one, const auto& other) {
    return one.first.min().x() < other.first.min().x();
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t k = i + 1; k < boxes.size(); ++k) {
      if (boxes[k].first.min().x() > boxes[i].first.max().x() + kMargin) break;
      PieceId a = boxes[i].second, b = boxes[k].second;
      if (a.drive == b.drive || boxes[i].first.exteriorDistance(boxes[k].first) > kMargin) continue;
      PairedPieces& pair = pair_of(pairs, a, b);
      pair.by_position.emplace(a.piece, b.piece);
    }
  }
}

/// How one place of a piece looks.
struct PieceAppearance {
  PieceId piece;
  const AppearanceKey* key;
};

/// Places that are looked up: all of a piece without positions. Where there is GNSS, one for each
/// piece is enough to notice that it contradicts the surroundings.
std::vector<PieceAppearance> queries_of(const DrivePieces& drive, std::size_t index) {
  std::vector<PieceAppearance> queries;
  for (std::size_t p = 0; p < drive.pieces.size(); ++p) {
    const auto& places = drive.pieces[p].places;
    if (drive.pieces[p].box) {
      if (!places.empty()) queries.push_back({{index, p}, &places[places.size() / 2]});
    } else {
      for (const AppearanceKey& key : places) queries.push_back({{index, p}, &key});
    }
  }
  return queries;
}

std::vector<PieceAppearance> appearances_of(const std::vector<DrivePieces>& drives) {
  std::vector<PieceAppearance> appearances;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    for (std::size_t p = 0; p < drives[d].pieces.size(); ++p) {
      for (const AppearanceKey& key : drives[d].pieces[p].places)
        appearances.push_back({{d, p}, &key});
    }
  }
  return appearances;
}

/// The most similar places of other drives, best first.
std::vector<PieceId> similar_places(const PieceAppearance& query,
                                    const std::vector<PieceAppearance>& appearances) {
  std::vector<std::pair<double, std::size_t>> nearest;
  for (std::size_t i = 0; i < appearances.size(); ++i) {
    if (appearances[i].piece.drive == query.piece.drive) continue;
    const double distance = distance_between(*query.key, *appearances[i].key);
    if (distance < kMaxDistance) nearest.emplace_back(distance, i);
  }
  std::sort(nearest.begin(), nearest.end());
  if (nearest.size() > kNearestPlaces) nearest.resize(kNearestPlaces);
  std::vector<PieceId> result;
  for (const auto& [distance, i] : nearest) result.push_back(appearances[i].piece);
  return result;
}

void pair_by_appearance(const std::vector<DrivePieces>& drives, PairedDrives& pairs) {
  const std::vector<PieceAppearance> appearances = appearances_of(drives);
  for (std::size_t d = 0; d < drives.size(); ++d) {
    for (const PieceAppearance& query : queries_of(drives[d], d)) {
      for (PieceId b : similar_places(query, appearances)) {
        PieceId a = query.piece;
        PairedPieces& pair = pair_of(pairs, a, b);
        ++pair.alike_places;
        pair.by_appearance.emplace(a.piece, b.piece);
      }
    }
  }
}

/// The piece and its neighbours to either side.
void add_around(std::size_t piece, std::size_t neighbours, std::size_t size,
                std::set<std::size_t>& pieces) {
  const std::size_t begin = piece - std::min(piece, neighbours);
  for (std::size_t p = begin; p <= std::min(piece + neighbours, size - 1); ++p) pieces.insert(p);
}

/// Partners in drive a of each piece of drive b.
std::map<std::size_t, std::set<std::size_t>> partners_of(const PairedPieces& pair,
                                                         const DrivePieces& a,
                                                         const DrivePieces& b) {
  std::map<std::size_t, std::set<std::size_t>> partners;
  for (const auto& [piece_a, piece_b] : pair.by_position) partners[piece_b].insert(piece_a);
  if (pair.alike_places < kMinAlikePlaces) return partners;
  for (const auto& [piece_a, piece_b] : pair.by_appearance) {
    std::set<std::size_t> around_b;
    add_around(piece_b, kNeighbours, b.pieces.size(), around_b);
    for (const std::size_t p : around_b) {
      add_around(piece_a, kNeighbours, a.pieces.size(), partners[p]);
    }
  }
  return partners;
}

/// Neighbouring pieces become one range.
std::vector<KeyFrameRange> ranges_of(const std::set<std::size_t>& pieces,
                                     const DrivePieces& drive) {
  std::vector<KeyFrameRange> ranges;
  std::size_t before = 0;
  for (const std::size_t p : pieces) {
    if (!ranges.empty() && p == before + 1) {
      ranges.back().last = drive.pieces[p].last;
    } else {
      ranges.push_back({drive.pieces[p].first, drive.pieces[p].last});
    }
    before = p;
  }
  return ranges;
}

std::vector<Chunk> chunks_of(const PairedPieces& pair, const DrivePieces& a, const DrivePieces& b) {
  std::vector<Chunk> chunks;
  const auto partners = partners_of(pair, a, b);
  for (auto begin = partners.begin(); begin != partners.end();) {
    std::set<std::size_t> a_pieces, b_pieces;
    auto entry = begin;
    for (; entry != partners.end() && b_pieces.size() < kMaxPieces; ++entry) {
      b_pieces.insert(entry->first);
      a_pieces.insert(entry->second.begin(), entry->second.end());
    }
    Chunk chunk;
    chunk.id = formatted("%s--%s--%03zu", a.drive.c_str(), b.drive.c_str(), chunks.size());
    chunk.a = a.drive;
    chunk.b = b.drive;
    chunk.a_ranges = ranges_of(a_pieces, a);
    chunk.b_ranges = ranges_of(b_pieces, b);
    chunk.by_position = !pair.by_position.empty();
    chunk.by_appearance = pair.alike_places >= kMinAlikePlaces;
    chunks.push_back(chunk);
    begin = entry;
  }
  return chunks;
}

}  // namespace

bool contains(const std::vector<KeyFrameRange>& ranges, KeyFrameIndex index) {
  return std::any_of(ranges.begin(), ranges.end(), [index](const KeyFrameRange& range) {
    return range.first <= index && index <= range.last;
  });
}

std::vector<Chunk> find_chunks(const std::vector<DrivePieces>& drives) {
  PairedDrives pairs;
  pair_by_position(drives, pairs);
  pair_by_appearance(drives, pairs);
  std::vector<Chunk> chunks;
  for (const auto& [pair, pieces] : pairs) {
    for (const Chunk& chunk : chunks_of(pieces, drives[pair.first], drives[pair.second])) {
      chunks.push_back(chunk);
    }
  }
  return chunks;
}

}  // namespace lidar_mapping::city
