// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"

#include "error_text.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pose_graph {
namespace {

G2oFile read(const std::string& text) {
  std::istringstream stream(text);
  return read_g2o(stream, "test.g2o");
}

std::string problem_of(const std::string& text) {
  return test::error_text<FileError>([&] { read(text); });
}

const std::string kIdentity6 = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

std::string edge(int from, int to, const std::string& information = kIdentity6) {
  return "EDGE_SE3:QUAT " + std::to_string(from) + " " + std::to_string(to) + " 1 0 0 0 0 0 1 " +
         information + "\n";
}

TEST(G2oFile, ReadsTheBitsThatItWrote) {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) {
    graph.nodes.push_back(
        {i * 7, {exp_so3({0.1 * i, 0.2, -0.3}), {i / 3.0, 1e6 + 0.1, -2.0 / 7.0}}});
  }
  Matrix6d information = Matrix6d::Identity() * 123.456789;
  information(0, 4) = information(4, 0) = 1.0 / 3.0;
  graph.edges.push_back({0, 7, graph.nodes[1].pose, information});
  graph.edges.push_back({14, 7, graph.nodes[2].pose, information});
  std::ostringstream first;
  write_g2o(graph, first);
  std::ostringstream second;
  write_g2o(read(first.str()).graph, second);
  EXPECT_EQ(first.str(), second.str());
}

TEST(G2oFile, LeavesNothingButTheFileThatItWrites) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "graph.g2o";
  write_g2o(read(edge(0, 1)).graph, path.string());
  EXPECT_EQ(read_g2o(path.string()).graph.edges.size(), 1U);
  std::filesystem::create_directories(folder.path() / "other.g2o" / "is a folder");
  EXPECT_THROW(write_g2o(read(edge(0, 1)).graph, (folder.path() / "other.g2o").string()),
               FileError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()),
                          std::filesystem::directory_iterator()),
            2)
      << "no temporary file";
}

TEST(G2oFile, KeepsPlanarGraphsPlanar) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0.5 0.25\nEDGE_SE2 0 1 1 0.5 0.25 10 1 2 20 3 30\n";
  const G2oFile file = read(text);
  EXPECT_TRUE(file.graph.planar);
  const Matrix6d& information = file.graph.edges[0].information;
  EXPECT_EQ(information(0, 0), 10.0);
  EXPECT_EQ(information(1, 5), 3.0);
  EXPECT_EQ(information(5, 5), 30.0);
  std::ostringstream out;
  write_g2o(file.graph, out);
  const G2oFile reread = read(out.str());
  EXPECT_NEAR(yaw_of(reread.graph.nodes[1].pose.rotation), 0.25, 1e-15);
  EXPECT_EQ(reread.graph.edges[0].information, information);
}

TEST(G2oFile, ComputesPosesOfVerticesThatAppearOnlyInEdges) {
  // The loop 2 -> 0 contradicts odometry and must not be used for start values.
  const G2oFile file = read(edge(0, 1) + edge(2, 0) + edge(1, 2) + edge(2, 3));
  ASSERT_EQ(file.graph.nodes.size(), 4U);
  EXPECT_NEAR(file.graph.nodes[3].pose.translation.x(), 3.0, 1e-12);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_NE(file.notes[0].find("4 of 4 vertices"), std::string::npos);
}

TEST(G2oFile, CrossesGapsOfTheChainByBackwardEdges) {
  const G2oFile file = read(edge(0, 1) + edge(5, 1) + edge(5, 6));
  EXPECT_NEAR(file.graph.nodes[2].pose.translation.x(), 0.0, 1e-12);
  EXPECT_NEAR(file.graph.nodes[3].pose.translation.x(), 1.0, 1e-12);
}

TEST(G2oFile, NormalisesQuaternions) {
  const G2oFile file =
      read("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 2\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n" + edge(0, 1));
  EXPECT_NEAR(file.graph.nodes[0].pose.rotation.norm(), 1.0, 1e-15);
}

TEST(G2oFile, RepairsIndefiniteInformationAndReportsIt) {
  const G2oFile file = read(edge(0, 1, "1 0 0 5 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1"));
  EXPECT_EQ(file.graph.edges[0].information(0, 3), 0.0);
  EXPECT_NE(file.notes.back().find("not positive definite"), std::string::npos);
}

TEST(G2oFile, RefusesInformationThatCannotBeRepaired) {
  EXPECT_NE(problem_of(edge(0, 1, "-1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1"))
                .find("test.g2o:1: the information matrix"),
            std::string::npos);
}

TEST(G2oFile, ReportsErrorsWithTheirLine) {
  EXPECT_NE(problem_of(edge(0, 1) + "EDGE_SE3:QUAT 1 2 1 0").find("test.g2o:2:"),
            std::string::npos);
  EXPECT_NE(problem_of(edge(0, 0)).find("joins a vertex with itself"), std::string::npos);
  EXPECT_NE(problem_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n" + edge(1, 2)).find("mixed"),
            std::string::npos);
  EXPECT_NE(problem_of("").find("no EDGE"), std::string::npos);
  EXPECT_NE(problem_of("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 0 0 0 0\n").find("twice"),
            std::string::npos);
  EXPECT_NE(problem_of("VERTEX_SE2 0 nan 0 0\n").find("finite"), std::string::npos);
  for (const char* id : {"9223372036854775807", "-9223372036854775808", "99999999999999999999"}) {
    EXPECT_NE(problem_of(std::string("VERTEX_SE2 ") + id + " 0 0 0\n").find("digits"),
              std::string::npos)
        << id;
  }
  EXPECT_THROW(read_g2o("/nonexistent.g2o"), FileError);
}

TEST(G2oFile, IgnoresUnknownLinesAndReportsThem) {
  const G2oFile file = read("# comment\n\nFIX 0\n" + edge(0, 1));
  EXPECT_NE(file.notes.back().find("'FIX'"), std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
