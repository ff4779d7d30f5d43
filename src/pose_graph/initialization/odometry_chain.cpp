// SPDX-License-Identifier: BSD-3-Clause
#include "initialization/odometry_chain.hpp"

#include <algorithm>
#include <cstdlib>
#include <deque>

namespace lidar_mapping::pose_graph {

namespace {

struct Neighbour {
  int node = 0;
  std::size_t edge = 0;
  bool forward = true;
};

std::vector<std::vector<Neighbour>> neighbours(const PoseGraph& graph) {
  std::vector<std::vector<Neighbour>> result(graph.nodes.size());
  const auto ends = edge_positions(graph);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    result[ends[i].first].push_back({ends[i].second, i, true});
    result[ends[i].second].push_back({ends[i].first, i, false});
  }
  return result;
}

/// A step along an edge from a placed node to a neighbour.
struct Step {
  int from = 0;
  Neighbour to;
};

/// Grows a spanning tree from the placed nodes. Edges of odometry are used first, others only if
/// there is no edge of odometry left.
class SpanningTree {
 public:
  SpanningTree(PoseGraph& graph, std::vector<bool> initialized)
      : graph_(graph), neighbours_(neighbours(graph)), initialized_(std::move(initialized)) {}

  void run() {
    for (std::size_t i = 0; i < initialized_.size(); ++i) {
      if (initialized_[i]) enqueue_edges(static_cast<int>(i));
    }
    expand();
    // Other components of the graph start at the current pose of their first node.
    for (std::size_t i = 0; i < initialized_.size(); ++i) {
      if (initialized_[i]) continue;
      initialized_[i] = true;
      enqueue_edges(static_cast<int>(i));
      expand();
    }
  }

 private:
  void enqueue_edges(int node) {
    for (const Neighbour& to : neighbours_[node]) {
      if (initialized_[to.node]) continue;
      (is_odometry(graph_.edges[to.edge]) ? odometry_ : others_).push_back({node, to});
    }
  }

  void expand() {
    while (!odometry_.empty() || !others_.empty()) {
      auto& queue = odometry_.empty() ? others_ : odometry_;
      const Step step = queue.front();
      queue.pop_front();
      const auto slot = static_cast<std::size_t>(step.to.node);
      if (initialized_[slot]) continue;
      const Pose& motion = graph_.edges[step.to.edge].T_from_to;
      graph_.nodes[slot].pose =
          graph_.nodes[step.from].pose * (step.to.forward ? motion : motion.inverse());
      initialized_[slot] = true;
      enqueue_edges(step.to.node);
    }
  }

  PoseGraph& graph_;
  std::vector<std::vector<Neighbour>> neighbours_;
  std::vector<bool> initialized_;
  std::deque<Step> odometry_;
  std::deque<Step> others_;
};

}  // namespace

std::vector<std::pair<int, int>> edge_positions(const PoseGraph& graph) {
  const std::int64_t first = graph.nodes.empty() ? 0 : graph.nodes.front().id;
  const bool has_gaps = graph.nodes.empty() || graph.nodes.back().id - first + 1 !=
                                                   static_cast<std::int64_t>(graph.nodes.size());
  const auto position = [&](std::int64_t id) {
    if (!has_gaps) return static_cast<int>(id - first);
    const auto found = std::lower_bound(
        graph.nodes.begin(), graph.nodes.end(), id,
        [](const PoseNode& node, std::int64_t wanted) { return node.id < wanted; });
    return static_cast<int>(found - graph.nodes.begin());
  };
  std::vector<std::pair<int, int>> result;
  result.reserve(graph.edges.size());
  for (const PoseEdge& edge : graph.edges) {
    result.emplace_back(position(edge.from), position(edge.to));
  }
  return result;
}

bool is_odometry(const PoseEdge& edge) { return std::abs(edge.from - edge.to) == 1; }

void initialize_along_edges(PoseGraph& graph, std::vector<bool> initialized) {
  SpanningTree(graph, std::move(initialized)).run();
}

}  // namespace lidar_mapping::pose_graph
