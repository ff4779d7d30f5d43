// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>
#include <string>
#include <vector>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"

#include "files/binary_graph_format.hpp"
#include "files/information_entries.hpp"

namespace lidar_mapping::pose_graph {

namespace {

using namespace binary_graph;

// Words that are written at once. Chosen: half a megabyte costs few calls of the system.
constexpr std::size_t kBufferWords = 65536;

class WordWriter {
 public:
  explicit WordWriter(std::ostream& stream) : stream_(stream) { buffer_.reserve(kBufferWords); }

  void word(Word value) {
    checksum_.add(value);
    buffer_.push_back(little_endian(value));
    if (buffer_.size() == kBufferWords) flush();
  }
  void integer(std::int64_t value) { word(static_cast<Word>(value)); }
  void number(double value) {
    Word bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    word(bits);
  }
  void finish() {
    word(checksum_.value());
    flush();
  }

 private:
  void flush() {
    stream_.write(reinterpret_cast<const char*>(buffer_.data()),
                  static_cast<std::streamsize>(buffer_.size() * sizeof(Word)));
    buffer_.clear();
  }

  std::ostream& stream_;
  std::vector<Word> buffer_;
  Checksum checksum_;
};

void write_pose(WordWriter& writer, const Pose& pose, bool planar) {
  for (int i = 0; i < (planar ? 2 : 3); ++i) writer.number(pose.translation[i]);
  if (planar) {
    writer.number(yaw_of(pose.rotation));
    return;
  }
  for (int i = 0; i < 4; ++i) writer.number(pose.rotation.coeffs()[i]);
}

void write_words(const PoseGraph& graph, WordWriter& writer) {
  writer.word(kMagic);
  writer.word(kVersion);
  writer.word(graph.planar ? 2 : 3);
  writer.word(graph.nodes.size());
  writer.word(graph.edges.size());
  for (const PoseNode& node : graph.nodes) {
    writer.integer(node.id);
    write_pose(writer, node.pose, graph.planar);
  }
  for (const PoseEdge& edge : graph.edges) {
    writer.integer(edge.from);
    writer.integer(edge.to);
    write_pose(writer, edge.T_from_to, graph.planar);
    visit_information(graph.planar,
                      [&](int row, int column) { writer.number(edge.information(row, column)); });
  }
  writer.finish();
}

}  // namespace

void write_binary_graph(const PoseGraph& graph, const std::string& path) {
  write_stream_atomically(path, [&](std::ostream& stream) {
    WordWriter writer(stream);
    write_words(graph, writer);
  });
}

}  // namespace lidar_mapping::pose_graph
