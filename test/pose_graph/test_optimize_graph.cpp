// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"

#include "file_content.hpp"
#include "temporary_folder.hpp"
#include "test_data.hpp"

namespace lidar_mapping::pose_graph {
namespace {

/// A recorded graph and its best known cost (g2o's chi2).
struct KnownGraph {
  const char* name;
  double best_cost;
};

class RecordedGraphs : public ::testing::TestWithParam<KnownGraph> {};

TEST_P(RecordedGraphs, ReachTheirBestKnownCost) {
  REQUIRE_RECORDED(folder, "pose_graphs");
  G2oFile file = read_g2o((folder / (GetParam().name + std::string(".g2o"))).string());
  const GraphReport report = optimize(file.graph);
  EXPECT_TRUE(report.success) << report.message;
  EXPECT_NEAR(report.final_cost, GetParam().best_cost, 1e-3 * GetParam().best_cost);
  EXPECT_LE(report.iterations, 10);
}

INSTANTIATE_TEST_SUITE_P(
    Files, RecordedGraphs,
    ::testing::Values(KnownGraph{"parking-garage", 1.23869058},
                      KnownGraph{"sphere2500", 727.149667}, KnownGraph{"torus3D", 14574.7464},
                      KnownGraph{"sphere_bignoise", 743862.721}, KnownGraph{"cubicle", 2379.90861},
                      KnownGraph{"kitti_00", 98.3220117}, KnownGraph{"manhattan", 3549.0368},
                      KnownGraph{"intel", 45.0046958}),
    [](const auto& graph) {
      std::string name = graph.param.name;
      for (char& c : name) c = c == '-' ? '_' : c;
      return name;
    });

/// Runs the command with files in a temporary folder.
class OptimizeGraph : public ::testing::Test {
 protected:
  /// Returns the exit status; the output of the command is the file "output".
  int run(const std::string& arguments) const {
    const std::string command = std::string(LIDAR_MAPPING_OPTIMIZE_GRAPH) + " " + arguments + " >" +
                                file("output") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name)) << text;
  }
  std::string text(const std::string& name) const { return test::content_of(file(name)); }
  nlohmann::json figures() const { return nlohmann::json::parse(text("figures.json")); }

 private:
  test::TemporaryFolder folder_;
};

const std::string kOnes = " 1 0 0 1 0 1\n";
/// A square of odometry with a scale error, closed by an edge in backward direction that is given
/// twice; without vertices.
const std::string kSquare =
    "EDGE_SE2 0 1 1.1 0 1.5707963267948966" + kOnes + "EDGE_SE2 1 2 1 0 1.5707963267948966" +
    kOnes + "EDGE_SE2 2 3 1 0 1.5707963267948966" + kOnes + "EDGE_SE2 3 0 1 0 1.5707963267948966" +
    kOnes + "EDGE_SE2 3 0 1 0 1.5707963267948966" + kOnes;

TEST_F(OptimizeGraph, WritesPosesAndFigures) {
  write("in.g2o", kSquare);
  ASSERT_EQ(run(file("in.g2o") + " " + file("out.g2o") + " --json " + file("figures.json")), 0)
      << text("output");
  const nlohmann::json json = figures();
  for (const char* key : {"nodes", "edges", "initial_cost", "final_cost", "iterations", "seconds",
                          "peak_memory_mb"}) {
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  EXPECT_EQ(json.at("nodes"), 4);
  EXPECT_EQ(json.at("edges"), 5);
  EXPECT_LT(json.at("final_cost"), json.at("initial_cost"));
  EXPECT_GT(json.at("peak_memory_mb"), 1.0);
}

TEST_F(OptimizeGraph, WritesEnoughDigitsForTheSameCost) {
  write("in.g2o", kSquare);
  ASSERT_EQ(run(file("in.g2o") + " " + file("out.g2o") + " --json " + file("figures.json")), 0);
  const double cost = figures().at("final_cost");
  ASSERT_EQ(run(file("out.g2o") + " " + file("again.g2o") + " --json " + file("figures.json")), 0);
  EXPECT_NEAR(figures().at("initial_cost"), cost, 1e-12 * cost);
}

TEST_F(OptimizeGraph, IteratesUntilTheToleranceIsReached) {
  write("in.g2o", kSquare);
  const std::string command =
      file("in.g2o") + " " + file("out.g2o") + " --json " + file("figures.json");
  ASSERT_EQ(run(command + " --tolerance 0.5"), 0) << text("output");
  const nlohmann::json early = figures();
  ASSERT_EQ(run(command + " --tolerance 1e-12"), 0) << text("output");
  const nlohmann::json late = figures();
  EXPECT_LT(early.at("iterations"), late.at("iterations"));
  EXPECT_LT(late.at("final_cost"), early.at("final_cost"));
  EXPECT_NE(run(command + " --tolerance 0"), 0);
}

TEST_F(OptimizeGraph, ReportsTheEdgesThatItRefuses) {
  std::string graph;
  for (int i = 0; i < 20; ++i) {
    graph += "EDGE_SE2 " + std::to_string(i) + " " + std::to_string(i + 1) +
             " 1 0 0 1e4 0 0 1e4 0 1e4\n";
  }
  write("in.g2o", graph + "EDGE_SE2 0 10 10 0 0 1e4 0 0 1e4 0 1e4\n" +
                      "EDGE_SE2 5 15 10 0 0 1e4 0 0 1e4 0 1e4\n" +
                      "EDGE_SE2 2 19 1 0 0 1e4 0 0 1e4 0 1e4\n");
  ASSERT_EQ(run(file("in.g2o") + " " + file("out.g2o") + " --robust graduated --json " +
                file("figures.json")),
            0);
  const nlohmann::json refused = figures().at("refused_edges");
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_EQ(refused[0].at("from"), 2);
  EXPECT_EQ(refused[0].at("to"), 19);
}

TEST_F(OptimizeGraph, AcceptsAllKernelNamesInUpperOrLowerCase) {
  write("in.g2o", kSquare);
  for (const char* kernel : {"NONE", "huber", "Cauchy", "DCS", "fair", "gemanmcclure",
                             "PseudoHuber", "saturated", "Tukey", "WELSCH", "Graduated"}) {
    EXPECT_EQ(run(file("in.g2o") + " " + file("out.g2o") + " --kernel-size 3 --robust " + kernel),
              0)
        << kernel << ": " << text("output");
  }
}

TEST_F(OptimizeGraph, BothMethodsAndBothFormatsLeadToTheSameCost) {
  write("in.g2o", kSquare);
  const std::string figures_option = " --tolerance 1e-12 --json " + file("figures.json");
  ASSERT_EQ(run(file("in.g2o") + " " + file("flat.lmg") + figures_option), 0) << text("output");
  EXPECT_EQ(figures().at("method"), "flat");
  const double cost = figures().at("final_cost");
  ASSERT_EQ(run(file("in.g2o") + " " + file("out.g2o") + " --method Condensed --threads 1" +
                figures_option),
            0)
      << text("output");
  EXPECT_EQ(figures().at("method"), "condensed");
  EXPECT_NEAR(figures().at("final_cost"), cost, 1e-6 * cost);
  ASSERT_EQ(run(file("flat.lmg") + " " + file("again.lmg") + figures_option), 0) << text("output");
  EXPECT_NEAR(figures().at("initial_cost"), cost, 1e-9 * cost);
  EXPECT_NE(run(file("in.g2o") + " " + file("out.g2o") + " --method dense"), 0);
  EXPECT_NE(text("output").find("condensed"), std::string::npos) << text("output");
}

TEST_F(OptimizeGraph, ReportsRepairs) {
  write("in.g2o", "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 5 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  EXPECT_EQ(run(file("in.g2o") + " " + file("out.g2o")), 0);
  EXPECT_NE(text("output").find("not positive definite"), std::string::npos) << text("output");
}

TEST_F(OptimizeGraph, RefusesInvalidInput) {
  EXPECT_NE(run(file("missing.g2o") + " " + file("out.g2o")), 0);
  EXPECT_NE(text("output").find("missing.g2o"), std::string::npos) << text("output");
  write("in.g2o", kSquare);
  EXPECT_NE(run(file("in.g2o") + " " + file("out.g2o") + " --robust Tuckey"), 0);
  EXPECT_NE(text("output").find("Cauchy"), std::string::npos) << text("output");
  write("bad.g2o", "EDGE_SE2 0 1 1 0\n");
  EXPECT_NE(run(file("bad.g2o") + " " + file("out.g2o")), 0);
  EXPECT_FALSE(std::filesystem::exists(file("out.g2o")));
  write("text.lmg", kSquare);
  EXPECT_NE(run(file("text.lmg") + " " + file("out.lmg")), 0);
  EXPECT_NE(text("output").find("is no binary pose graph"), std::string::npos) << text("output");
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
