// SPDX-License-Identifier: BSD-3-Clause
// Large pose graphs to measure optimize_graph with, and how far two of its solutions lie apart.

#include "street_graph.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"

namespace {

using namespace lidar_mapping;
using namespace lidar_mapping::pose_graph;

void make(const test::StreetSettings& settings, const std::string& path) {
  const test::StreetGraph streets = test::make_street_graph(settings);
  write_graph(streets.graph, path);
  std::printf("%zu key frames, %zu loops\n", streets.graph.nodes.size(),
              streets.graph.edges.size() + 1 - streets.graph.nodes.size());
}

/// Both solutions hold their first node where it was, so that they need no alignment.
void compare(const std::string& first_path, const std::string& second_path) {
  const PoseGraph first = read_graph(first_path).graph;
  const PoseGraph second = read_graph(second_path).graph;
  if (first.nodes.size() != second.nodes.size()) {
    throw InputError("the graphs have different nodes; compare solutions of one graph");
  }
  double largest_m = 0.0, largest_rad = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < first.nodes.size(); ++i) {
    const Pose& a = first.nodes[i].pose;
    const Pose& b = second.nodes[i].pose;
    const double squared = (a.translation - b.translation).squaredNorm();
    sum += squared;
    largest_m = std::max(largest_m, std::sqrt(squared));
    largest_rad = std::max(largest_rad, rotation_angle(a.rotation.conjugate() * b.rotation));
  }
  std::printf("largest difference %.6f m, %.7f rad; root mean square %.6f m\n", largest_m,
              largest_rad, std::sqrt(sum / static_cast<double>(first.nodes.size())));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes large pose graphs of drives through a town, and compares solutions.");
  app.require_subcommand(1);
  test::StreetSettings settings;
  std::string first, second;
  CLI::App* const maker = app.add_subcommand("make", "write the graph of a drive");
  maker->add_option("output", first, "file to write, .g2o or .lmg")->required();
  maker->add_option("--key-frames", settings.key_frames, "one per metre")->capture_default_str();
  maker->add_option("--loops", settings.loops, "at most")->capture_default_str();
  maker->add_option("--blocks", settings.blocks, "per side of the town; 0: 1.2 passes per street")
      ->capture_default_str();
  maker->add_option("--seed", settings.seed, "of the noise and the way")->capture_default_str();
  CLI::App* const comparer = app.add_subcommand("compare", "largest difference of the poses");
  comparer->add_option("first", first, "solution")->required();
  comparer->add_option("second", second, "solution of the same graph")->required();
  try {
    app.parse(argc, argv);
    maker->parsed() ? make(settings, first) : compare(first, second);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "street_graph: %s\n", error.what());
    return 1;
  }
}
