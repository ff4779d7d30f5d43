// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/graph_file.hpp"

#include <filesystem>

namespace lidar_mapping::pose_graph {

namespace {

bool is_binary(const std::string& path) {
  return std::filesystem::path(path).extension() == ".lmg";
}

}  // namespace

G2oFile read_graph(const std::string& path) {
  if (is_binary(path)) return {read_binary_graph(path), {}};
  return read_g2o(path);
}

void write_graph(const PoseGraph& graph, const std::string& path) {
  if (is_binary(path)) {
    write_binary_graph(graph, path);
  } else {
    write_g2o(graph, path);
  }
}

}  // namespace lidar_mapping::pose_graph
