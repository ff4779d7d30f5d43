// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"

#include "files/binary_graph_format.hpp"
#include "files/information_entries.hpp"

namespace lidar_mapping::pose_graph {

namespace {

using namespace binary_graph;

// Records that are read at once, and that one thread decodes at a time. Chosen: some megabytes keep
// all cores busy and cost no memory that counts.
constexpr std::size_t kBlockRecords = 32768;
constexpr std::size_t kRecordsAtATime = 2048;
// By how much the length of a quaternion may differ from 1. Chosen: far above the rounding of
// doubles, far below any error of a rotation that matters.
constexpr double kQuaternionRounding = 1e-9;

/// Reads the words of a file, in blocks of whole records.
class WordReader {
 public:
  explicit WordReader(const std::string& path) : path_(path), stream_(open_for_reading(path)) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    words_ = error ? 0 : static_cast<std::size_t>(bytes / sizeof(Word));
    is_whole_ = !error && bytes % sizeof(Word) == 0;
  }

  std::size_t words() const { return words_; }
  bool is_whole() const { return is_whole_; }
  /// Of all words that were read so far.
  Word checksum() const { return checksum_.value(); }

  /// The next `count` words, until the next call.
  const std::vector<Word>& read(std::size_t count) {
    block_.resize(count);
    stream_.read(reinterpret_cast<char*>(block_.data()),
                 static_cast<std::streamsize>(count * sizeof(Word)));
    if (!stream_) fail("is cut; copy it again");
    for (Word& word : block_) {
      word = little_endian(word);
      checksum_.add(word);
    }
    return block_;
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw FileError(path_ + " " + problem);
  }

 private:
  std::string path_;
  std::ifstream stream_;
  std::size_t words_ = 0;
  bool is_whole_ = true;
  std::vector<Word> block_;
  Checksum checksum_;
};

/// The numbers of one record.
class Record {
 public:
  Record(const Word* words, const WordReader& reader) : next_(words), reader_(reader) {}

  std::int64_t integer() { return static_cast<std::int64_t>(*next_++); }

  double number() {
    double value = 0.0;
    std::memcpy(&value, next_++, sizeof value);
    if (!std::isfinite(value)) fail("holds a number that is not finite; write it again");
    return value;
  }

  double coordinate() {
    const double value = number();
    if (std::abs(value) > kMaxCoordinate) fail("has a pose beyond a million kilometres");
    return value;
  }

  [[noreturn]] void fail(const std::string& problem) const { reader_.fail(problem); }

 private:
  const Word* next_;
  const WordReader& reader_;
};

Pose read_pose(Record& record, bool planar) {
  Pose pose;
  for (int i = 0; i < (planar ? 2 : 3); ++i) pose.translation[i] = record.coordinate();
  if (planar) {
    pose.rotation = exp_so3({0.0, 0.0, record.coordinate()});
    return pose;
  }
  for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = record.coordinate();
  if (std::abs(pose.rotation.norm() - 1.0) > kQuaternionRounding) {
    record.fail("has a quaternion whose length is not 1; write it again");
  }
  return pose;
}

Matrix6d read_information(Record& record, bool planar) {
  Matrix6d information = Matrix6d::Identity();
  visit_information(planar, [&](int row, int column) {
    information(row, column) = information(column, row) = record.number();
  });
  if (Eigen::LLT<Matrix6d>(information).info() != Eigen::Success) {
    record.fail("has an information matrix that is not positive definite; read_g2o() repairs such");
  }
  return information;
}

bool has_node(const PoseGraph& graph, std::int64_t id) {
  const auto found =
      std::lower_bound(graph.nodes.begin(), graph.nodes.end(), id,
                       [](const PoseNode& node, std::int64_t wanted) { return node.id < wanted; });
  return found != graph.nodes.end() && found->id == id;
}

/// Sizes of a graph.
struct Header {
  bool planar = false;
  std::size_t nodes = 0;
  std::size_t edges = 0;
};

Header read_header(WordReader& reader) {
  if (reader.words() < kHeaderWords || reader.read(1)[0] != kMagic) {
    reader.fail("is no binary pose graph; a file in g2o's format must not end in .lmg");
  }
  const std::vector<Word>& words = reader.read(kHeaderWords - 1);
  if (words[0] != kVersion) {
    reader.fail("is of version " + std::to_string(words[0]) + ", but this program reads version " +
                std::to_string(kVersion) + "; convert it with the program that wrote it");
  }
  if (words[1] != 2 && words[1] != 3) {
    reader.fail("has " + std::to_string(words[1]) + " dimensions; there are graphs of 2 and 3");
  }
  Header header;
  header.planar = words[1] == 2;
  header.nodes = static_cast<std::size_t>(words[2]);
  header.edges = static_cast<std::size_t>(words[3]);
  // Compared without products, which could overflow. The last word is the checksum.
  const std::size_t body = reader.words() - kHeaderWords;
  const std::size_t node_size = node_words(header.planar), edge_size = edge_words(header.planar);
  const bool fits = header.nodes <= body / node_size && header.edges <= body / edge_size;
  if (!fits || !reader.is_whole() ||
      header.nodes * node_size + header.edges * edge_size + 1 != body) {
    reader.fail("names " + std::to_string(header.nodes) + " nodes and " +
                std::to_string(header.edges) + " edges, which is not its size; copy it again");
  }
  if (header.nodes == 0 || header.edges == 0) {
    reader.fail("has no nodes or no edges; there is nothing to optimise");
  }
  return header;
}

/// Reads `count` records and calls `decode` with each of them and its number, on all cores.
template <typename Decode>
void read_records(WordReader& reader, std::size_t count, std::size_t record_words,
                  const Decode& decode) {
  for (std::size_t first = 0; first < count; first += kBlockRecords) {
    const std::size_t block = std::min(kBlockRecords, count - first);
    const std::vector<Word>& words = reader.read(block * record_words);
    parallel_chunks(block, kRecordsAtATime, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Record record(words.data() + i * record_words, reader);
        decode(record, first + i);
      }
    });
  }
}

void read_nodes(WordReader& reader, const Header& header, PoseGraph& graph) {
  graph.nodes.resize(header.nodes);
  read_records(reader, header.nodes, node_words(header.planar), [&](Record& record, std::size_t i) {
    graph.nodes[i].id = record.integer();
    graph.nodes[i].pose = read_pose(record, header.planar);
  });
  for (std::size_t i = 1; i < graph.nodes.size(); ++i) {
    if (graph.nodes[i].id > graph.nodes[i - 1].id) continue;
    reader.fail("has node " + std::to_string(graph.nodes[i].id) + " after node " +
                std::to_string(graph.nodes[i - 1].id) + "; ids must ascend");
  }
}

void read_edges(WordReader& reader, const Header& header, PoseGraph& graph) {
  graph.edges.resize(header.edges);
  read_records(reader, header.edges, edge_words(header.planar), [&](Record& record, std::size_t i) {
    PoseEdge& edge = graph.edges[i];
    edge.from = record.integer();
    edge.to = record.integer();
    if (edge.from == edge.to || !has_node(graph, edge.from) || !has_node(graph, edge.to)) {
      record.fail("has an edge from " + std::to_string(edge.from) + " to " +
                  std::to_string(edge.to) + "; it must join two of its nodes");
    }
    edge.T_from_to = read_pose(record, header.planar);
    edge.information = read_information(record, header.planar);
  });
}

}  // namespace

PoseGraph read_binary_graph(const std::string& path) {
  WordReader reader(path);
  const Header header = read_header(reader);
  PoseGraph graph;
  graph.planar = header.planar;
  read_nodes(reader, header, graph);
  read_edges(reader, header, graph);
  const Word expected = reader.checksum();
  if (reader.read(1)[0] != expected) reader.fail("has a wrong checksum; copy it again");
  return graph;
}

}  // namespace lidar_mapping::pose_graph
