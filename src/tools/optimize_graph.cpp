// SPDX-License-Identifier: BSD-3-Clause
// Optimises a pose graph in a file, binary or g2o's text.

#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"
#include "lidar_mapping/pose_graph/graph_optimizer.hpp"

#include "command_line/number_checks.hpp"
#include "command_line/process_memory.hpp"
#include "command_line/run_command.hpp"
#include "json.hpp"

namespace {

using namespace lidar_mapping;
using json::Json;
using namespace lidar_mapping::pose_graph;

constexpr const char* kGraduated = "graduated";

struct Arguments {
  std::string input;
  std::string output;
  std::string robust = "none";
  std::string method = "auto";
  int threads = GraphOptions().threads;
  double kernel_size = GraphOptions().kernel_size;
  double tolerance = GraphOptions().tolerance;
  std::string json;
};

std::vector<std::string> robust_names() {
  std::vector<std::string> names = {kGraduated};
  for (const auto& entry : robust_kernel_names()) names.push_back(entry.first);
  return names;
}

const std::map<std::string, GraphMethod>& methods() {
  static const std::map<std::string, GraphMethod> names = {{"auto", GraphMethod::kAutomatic},
                                                           {"condensed", GraphMethod::kCondensed},
                                                           {"flat", GraphMethod::kFlat}};
  return names;
}

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const auto& entry : methods()) names.push_back(entry.first);
  return names;
}

GraphOptions options_of(const Arguments& arguments) {
  GraphOptions options;
  options.graduated = arguments.robust == kGraduated;
  options.kernel_size = arguments.kernel_size;
  options.tolerance = arguments.tolerance;
  options.method = methods().at(arguments.method);
  options.threads = arguments.threads;
  if (!options.graduated) options.kernel = robust_kernel_of(arguments.robust);
  return options;
}

double wall_seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

Json refused_edges(const PoseGraph& graph, const GraphReport& report) {
  Json list = Json::array();
  for (const std::size_t i : report.refused) {
    list.push_back({{"edge", i}, {"from", graph.edges[i].from}, {"to", graph.edges[i].to}});
  }
  return list;
}

void write_json(const std::string& path, const G2oFile& file, const GraphReport& report,
                double seconds, double elapsed) {
  const Json document = {{"nodes", file.graph.nodes.size()},
                         {"edges", file.graph.edges.size()},
                         {"method", report.method},
                         {"initial_cost", report.initial_cost},
                         {"start", report.start},
                         {"start_cost", report.start_cost},
                         {"final_cost", report.final_cost},
                         {"iterations", report.iterations},
                         {"seconds", seconds},
                         {"wall_seconds", elapsed},
                         {"peak_memory_mb", tools::peak_mebibytes()},
                         {"success", report.success},
                         {"notes", file.notes},
                         {"refused_edges", refused_edges(file.graph, report)}};
  write_text_atomically(path, json::dumped(document, 2) + "\n");
}

int run(const Arguments& arguments) {
  G2oFile file = read_graph(arguments.input);
  for (const std::string& note : file.notes) std::printf("note: %s\n", note.c_str());
  const double begin = cpu_seconds(), begin_wall = wall_seconds();
  const GraphReport report = optimize(file.graph, options_of(arguments));
  const double seconds = cpu_seconds() - begin, elapsed = wall_seconds() - begin_wall;
  std::printf(
      "%zu nodes, %zu edges, %s: cost %.9g -> %.9g in %d iterations, %.3f s CPU; %zu edges "
      "refused\n",
      file.graph.nodes.size(), file.graph.edges.size(), report.method.c_str(), report.initial_cost,
      report.final_cost, report.iterations, seconds, report.refused.size());
  write_graph(file.graph, arguments.output);
  if (!arguments.json.empty()) write_json(arguments.json, file, report, seconds, elapsed);
  if (!report.success) std::fprintf(stderr, "the solver failed: %s\n", report.message.c_str());
  return report.success ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Optimises a pose graph in a file: g2o's text (SE2 or SE3), or binary (.lmg).");
  app.add_option("input", arguments.input, "file to read, .g2o or .lmg")->required();
  app.add_option("output", arguments.output, "file to write, .g2o or .lmg")->required();
  app.add_option("--robust", arguments.robust,
                 "graduated: decides which loops are used; or the name of a kernel for all loops")
      ->transform(CLI::IsMember(robust_names(), CLI::ignore_case))
      ->capture_default_str();
  app.add_option("--kernel-size", arguments.kernel_size, "standard deviations")
      ->check(tools::above_zero())
      ->capture_default_str();
  app.add_option("--tolerance", arguments.tolerance,
                 "end when a step is expected to reduce the cost by less than this fraction")
      ->check(tools::above_zero())
      ->capture_default_str();
  app.add_option("--method", arguments.method,
                 "condensed: piece by piece, for large graphs; flat: all nodes at once")
      ->transform(CLI::IsMember(method_names(), CLI::ignore_case))
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "of the condensed method; 0: all cores")
      ->check(tools::not_negative())
      ->capture_default_str();
  app.add_option("--json", arguments.json, "file for the figures");
  return tools::run_command(app, argc, argv, [&] { return run(arguments); });
}
