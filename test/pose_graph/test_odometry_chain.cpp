// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <gtest/gtest.h>

#include "initialization/odometry_chain.hpp"
#include "near.hpp"

namespace lidar_mapping::pose_graph {
namespace {

Pose at(double x, double y, double yaw = 0.0) { return {exp_so3({0.0, 0.0, yaw}), {x, y, 0.0}}; }

PoseEdge edge(std::int64_t from, std::int64_t to, const Pose& T_from_to) {
  PoseEdge result;
  result.from = from;
  result.to = to;
  result.T_from_to = T_from_to;
  return result;
}

/// Nodes with these ids; all of them are far away.
PoseGraph graph_of(const std::vector<std::int64_t>& ids, const std::vector<PoseEdge>& edges) {
  PoseGraph graph;
  for (const std::int64_t id : ids) graph.nodes.push_back({id, at(1000.0, 1000.0)});
  graph.edges = edges;
  return graph;
}

std::vector<bool> only_first(const PoseGraph& graph) {
  std::vector<bool> initialized(graph.nodes.size(), false);
  initialized[0] = true;
  return initialized;
}

TEST(EdgePositions, AreThoseOfTheIdsWithGaps) {
  const PoseGraph graph = graph_of({3, 7, 8, 40}, {edge(7, 40, {}), edge(40, 3, {})});
  EXPECT_EQ(edge_positions(graph), (std::vector<std::pair<int, int>>{{1, 3}, {3, 0}}));
  EXPECT_TRUE(edge_positions(graph_of({}, {})).empty());
}

TEST(Odometry, JoinsNeighbouringIds) {
  EXPECT_TRUE(is_odometry(edge(4, 5, {})));
  EXPECT_TRUE(is_odometry(edge(5, 4, {})));
  EXPECT_FALSE(is_odometry(edge(4, 6, {})));
  EXPECT_FALSE(is_odometry(edge(4, 4, {})));
}

TEST(OdometryChain, FollowsTheEdgesFromTheFirstNode) {
  PoseGraph graph = graph_of({0, 1, 2}, {edge(0, 1, at(2.0, 0.0, 0.5)), edge(1, 2, at(3.0, 0.0))});
  graph.nodes[0].pose = at(10.0, 5.0, 0.2);
  initialize_along_edges(graph, only_first(graph));
  EXPECT_TRUE(test::near(graph.nodes[0].pose, at(10.0, 5.0, 0.2), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[1].pose, at(10.0, 5.0, 0.2) * at(2.0, 0.0, 0.5), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[2].pose, at(10.0, 5.0, 0.2) * at(2.0, 0.0, 0.5) * at(3.0, 0.0),
                         1e-12));
}

TEST(OdometryChain, FollowsAnEdgeInEitherDirection) {
  const Pose motion = at(2.0, 1.0, 0.5);
  PoseGraph graph = graph_of({0, 1}, {edge(1, 0, motion)});
  graph.nodes[0].pose = at(0.0, 0.0);
  initialize_along_edges(graph, only_first(graph));
  EXPECT_TRUE(test::near(graph.nodes[1].pose, motion.inverse(), 1e-12));
}

// A loop leads to node 2 by one step, odometry by two: the loop may be false.
TEST(OdometryChain, FollowsOdometryBeforeLoops) {
  PoseGraph graph = graph_of(
      {0, 1, 2}, {edge(0, 2, at(-77.0, 0.0)), edge(0, 1, at(1.0, 0.0)), edge(1, 2, at(1.0, 0.0))});
  graph.nodes[0].pose = at(0.0, 0.0);
  initialize_along_edges(graph, only_first(graph));
  EXPECT_TRUE(test::near(graph.nodes[2].pose, at(2.0, 0.0), 1e-12));
}

// Between 1 and 2 odometry is missing.
TEST(OdometryChain, CrossesGapsByLoopsAndGoesOnByOdometry) {
  PoseGraph graph = graph_of({0, 1, 2, 3}, {edge(0, 1, at(1.0, 0.0)), edge(0, 3, at(0.0, 5.0)),
                                            edge(1, 3, at(0.0, 99.0)), edge(2, 3, at(1.0, 0.0))});
  graph.nodes[0].pose = at(0.0, 0.0);
  initialize_along_edges(graph, only_first(graph));
  EXPECT_TRUE(test::near(graph.nodes[3].pose, at(0.0, 5.0), 1e-12)) << "by the first loop";
  EXPECT_TRUE(test::near(graph.nodes[2].pose, at(-1.0, 5.0), 1e-12)) << "back by odometry";
}

TEST(OdometryChain, LeavesInitializedNodesAndBeginsFromAllOfThem) {
  PoseGraph graph = graph_of(
      {0, 1, 2, 3}, {edge(0, 1, at(1.0, 0.0)), edge(1, 2, at(1.0, 0.0)), edge(2, 3, at(1.0, 0.0))});
  graph.nodes[0].pose = at(0.0, 0.0);
  graph.nodes[2].pose = at(50.0, 0.0);
  initialize_along_edges(graph, {true, false, true, false});
  EXPECT_TRUE(test::near(graph.nodes[1].pose, at(1.0, 0.0), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[2].pose, at(50.0, 0.0), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[3].pose, at(51.0, 0.0), 1e-12));
}

TEST(OdometryChain, BeginsEachOtherComponentAtItsFirstNode) {
  PoseGraph graph =
      graph_of({0, 1, 10, 11}, {edge(0, 1, at(1.0, 0.0)), edge(10, 11, at(1.0, 0.0))});
  graph.nodes[2].pose = at(0.0, 300.0);
  initialize_along_edges(graph, std::vector<bool>(4, false));
  EXPECT_TRUE(test::near(graph.nodes[0].pose, at(1000.0, 1000.0), 1e-12)) << "nothing moves it";
  EXPECT_TRUE(test::near(graph.nodes[1].pose, at(1001.0, 1000.0), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[2].pose, at(0.0, 300.0), 1e-12));
  EXPECT_TRUE(test::near(graph.nodes[3].pose, at(1.0, 300.0), 1e-12));
}

}  // namespace
}  // namespace lidar_mapping::pose_graph
