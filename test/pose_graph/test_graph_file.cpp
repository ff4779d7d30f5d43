// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pose_graph {
namespace {

PoseGraph example(bool planar) {
  PoseGraph graph;
  graph.planar = planar;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d turn(planar ? 0.0 : 0.1 * i, 0.0, -0.3 * i);
    graph.nodes.push_back({i * 7 - 3, {exp_so3(turn), {i / 3.0, 1e6 + 0.1, planar ? 0.0 : -0.2}}});
  }
  Matrix6d information = Matrix6d::Identity() * 123.456789;
  information(0, 5) = information(5, 0) = 1.0 / 3.0;
  for (int i = 1; i < 4; ++i) {
    graph.edges.push_back({i * 7 - 3, i * 7 - 10, graph.nodes[1].pose, information});
  }
  return graph;
}

std::string text_of(const PoseGraph& graph) {
  std::ostringstream text;
  write_g2o(graph, text);
  return text.str();
}

class BinaryGraph : public ::testing::Test {
 protected:
  void SetUp() override { write_binary_graph(example(false), path()); }

  std::string path() const { return (folder_.path() / "graph.lmg").string(); }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string problem() const {
    return test::error_text<FileError>([&] { read_binary_graph(path()); });
  }
  bool says(const std::string& words) const { return problem().find(words) != std::string::npos; }

  void write_bytes(const std::string& bytes) const {
    std::ofstream(path(), std::ios::binary | std::ios::trunc) << bytes;
  }

  /// Writes the example with another word at a position, and with the right checksum.
  template <typename Value>
  void write_with(std::size_t position, Value value) const {
    static_assert(sizeof(Value) == 8);
    write_binary_graph(example(false), path());
    std::string bytes = test::content_of(path());
    std::memcpy(bytes.data() + 8 * position, &value, 8);
    std::uint64_t checksum = 0xcbf29ce484222325;
    for (std::size_t i = 0; i + 16 <= bytes.size(); i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, 8);
      checksum = (checksum ^ word) * 0x100000001b3;
    }
    std::memcpy(bytes.data() + bytes.size() - 8, &checksum, 8);
    write_bytes(bytes);
  }

  test::TemporaryFolder folder_;
};

// Where the words are: the header, four nodes of 8 words, edges of 30 words.
constexpr std::size_t kFirstNode = 5;
constexpr std::size_t kFirstEdge = kFirstNode + 4 * 8;

TEST_F(BinaryGraph, ReadsTheBitsThatItWrote) {
  const PoseGraph graph = example(false);
  const PoseGraph read = read_binary_graph(path());
  EXPECT_FALSE(read.planar);
  ASSERT_EQ(read.nodes.size(), graph.nodes.size());
  ASSERT_EQ(read.edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    EXPECT_EQ(read.nodes[i].id, graph.nodes[i].id);
    EXPECT_EQ(read.nodes[i].pose.translation, graph.nodes[i].pose.translation);
    EXPECT_EQ(read.nodes[i].pose.rotation.coeffs(), graph.nodes[i].pose.rotation.coeffs());
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].from, graph.edges[i].from);
    EXPECT_EQ(read.edges[i].to, graph.edges[i].to);
    EXPECT_EQ(read.edges[i].T_from_to.translation, graph.edges[i].T_from_to.translation);
    EXPECT_EQ(read.edges[i].information, graph.edges[i].information);
  }
}

TEST_F(BinaryGraph, KeepsPlanarGraphsPlanar) {
  write_binary_graph(example(true), path());
  const PoseGraph read = read_binary_graph(path());
  EXPECT_TRUE(read.planar);
  EXPECT_NEAR(yaw_of(read.nodes[3].pose.rotation), -0.9, 1e-15);
  EXPECT_EQ(read.nodes[3].pose.translation, example(true).nodes[3].pose.translation);
  EXPECT_EQ(read.edges[2].information(0, 5), 1.0 / 3.0);
}

TEST_F(BinaryGraph, TheNameOfTheFileDecidesItsFormat) {
  write_graph(example(false), path("a.lmg"));
  write_graph(example(false), path("a.g2o"));
  EXPECT_EQ(test::content_of(path("a.lmg")).substr(0, 8), "LMGRAPH\n");
  EXPECT_EQ(test::content_of(path("a.g2o")), text_of(example(false)));
  EXPECT_EQ(text_of(read_graph(path("a.lmg")).graph), text_of(read_graph(path("a.g2o")).graph));
}

TEST_F(BinaryGraph, LongFilesAreReadInParts) {
  PoseGraph graph = example(false);
  for (int i = 0; i < 33000; ++i) {  // more records than are read at once
    graph.nodes.push_back({100 + i, graph.nodes[1].pose});
    graph.edges.push_back({100 + i, 4, graph.nodes[2].pose, graph.edges[0].information});
  }
  write_binary_graph(graph, path());
  EXPECT_EQ(text_of(read_binary_graph(path())), text_of(graph));
}

TEST_F(BinaryGraph, RefusesWhatIsNoSuchFile) {
  write_bytes("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1 and more than five words of eight bytes");
  EXPECT_TRUE(says("is no binary pose graph")) << problem();
  write_bytes("");
  EXPECT_TRUE(says("is no binary pose graph")) << problem();
  write_with(1, std::uint64_t{2});
  EXPECT_TRUE(says("version 2")) << problem();
  write_with(2, std::uint64_t{4});
  EXPECT_TRUE(says("4 dimensions")) << problem();
  EXPECT_THROW(read_binary_graph(path("missing.lmg")), FileError);
  EXPECT_THROW(read_graph(folder_.path().string()), FileError);
}

TEST_F(BinaryGraph, RefusesSizesThatAreNotThoseOfTheFile) {
  const std::string bytes = test::content_of(path());
  for (const std::size_t size : {bytes.size() - 1, bytes.size() - 8, bytes.size() / 2}) {
    write_bytes(bytes.substr(0, size));
    EXPECT_TRUE(says("copy it again")) << size << ": " << problem();
  }
  write_bytes(bytes + "12345678");
  EXPECT_TRUE(says("copy it again")) << problem();
  for (const std::size_t count : {std::size_t{3}, std::size_t{4}}) {
    for (const std::uint64_t value :
         {std::uint64_t{5}, std::numeric_limits<std::uint64_t>::max(), std::uint64_t{1} << 60}) {
      write_with(count, value);
      EXPECT_TRUE(says("copy it again")) << value << ": " << problem();
    }
  }
}

TEST_F(BinaryGraph, NoticesEveryChangedByte) {
  const std::string bytes = test::content_of(path());
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    write_bytes(changed);
    EXPECT_THROW(read_binary_graph(path()), FileError) << "byte " << i;
  }
}

TEST_F(BinaryGraph, RefusesNumbersThatNoGraphHas) {
  write_with(kFirstNode + 1, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(says("not finite")) << problem();
  write_with(kFirstNode + 1, 1e12);
  EXPECT_TRUE(says("million kilometres")) << problem();
  write_with(kFirstNode + 7, 3.0);
  EXPECT_TRUE(says("quaternion")) << problem();
  write_with(kFirstNode + 8, std::int64_t{-3});
  EXPECT_TRUE(says("ids must ascend")) << problem();
  write_with(kFirstEdge, std::int64_t{5});
  EXPECT_TRUE(says("edge from 5 to")) << problem();
  write_with(kFirstEdge + 1, std::int64_t{4});
  EXPECT_TRUE(says("edge from 4 to 4")) << problem();
  write_with(kFirstEdge + 9, -1.0);
  EXPECT_TRUE(says("not positive definite")) << problem();
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
