// SPDX-License-Identifier: BSD-3-Clause
#include "initialization/coarse_initialization.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "condensed/condensed_minimizer.hpp"
#include "condensed/pose_graph_problem.hpp"
#include "initialization/chordal_initialization.hpp"
#include "initialization/odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

// Key frames of a piece. Chosen: odometry hardly drifts over so few, and 30 times fewer unknowns
// cost next to nothing.
constexpr int kPieceNodes = 32;
// Gauss-Newton steps of the coarse graph at most, and the fraction of its cost below which a gain
// is left to the whole graph, which is solved afterwards. Chosen: one step does after the
// relaxation.
constexpr int kCoarseSteps = 5;
constexpr double kCoarseTolerance = 0.1;

/// How uncertain a relative pose is, the same in all directions: translation (m^2) and vector part
/// of the quaternion.
struct Spread {
  double translation = 0.0;
  double rotation = 0.0;
};

/// Spread of a pose behind another one that is `lever` long.
Spread sum(const Spread& first, const Spread& second, double lever) {
  // A vector part is half a rotation vector.
  return {first.translation + second.translation + 4.0 * first.rotation * lever * lever,
          first.rotation + second.rotation};
}

Spread spread_of(const PoseEdge& edge, bool planar) {
  if (planar) {
    const Eigen::Matrix2d translation = edge.information.topLeftCorner<2, 2>();
    return {translation.inverse().trace() / 2.0, 0.25 / edge.information(5, 5)};
  }
  const Eigen::Matrix3d translation = edge.information.topLeftCorner<3, 3>();
  const Eigen::Matrix3d rotation = edge.information.bottomRightCorner<3, 3>();
  return {translation.inverse().trace() / 3.0, rotation.inverse().trace() / 3.0};
}

Matrix6d information_of(const Spread& spread, bool planar) {
  Vector6d diagonal = Vector6d::Constant(1.0 / spread.translation);
  diagonal.tail<3>().setConstant((planar ? 0.25 : 1.0) / spread.rotation);
  return diagonal.asDiagonal();
}

/// A node in the piece that it belongs to. There is one for each node, so that it is kept small.
struct Placed {
  Pose T_start_node;  ///< in the first node of the piece, by odometry
  int piece = 0;
  float translation = 0.0F;  ///< of its spread there
  float rotation = 0.0F;

  Spread spread() const { return {translation, rotation}; }
};

class CoarseInitialization {
 public:
  explicit CoarseInitialization(PoseGraph& graph) : graph_(graph), ends_(edge_positions(graph)) {}

  bool run(int threads) {
    divide();
    build_coarse_graph();
    if (!initialize_chordally(coarse_)) return false;
    if (graph_.planar) {
      improve<3>(threads);
    } else {
      improve<6>(threads);
    }
    place_nodes();
    return true;
  }

 private:
  template <int size>
  void improve(int threads) {
    const auto problem = make_condensed_problem<size>(coarse_, RobustKernel::kNone, 1.0);
    minimize_condensed<size>(*problem, condensed_structure<size>(*problem, threads),
                             {kCoarseSteps, std::nullopt, kCoarseTolerance, {}}, threads);
  }

  /// The first edge of odometry to each node from the one before; -1: none.
  std::vector<int> chain_edges() const {
    std::vector<int> chain(graph_.nodes.size(), -1);
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const auto [a, b] = std::minmax({ends_[i].first, ends_[i].second});
      if (b - a == 1 && chain[b] < 0) chain[b] = static_cast<int>(i);
    }
    return chain;
  }

  void divide() {
    const std::vector<int> chain = chain_edges();
    placed_.resize(graph_.nodes.size());
    int length = 0;
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (chain[i] < 0 || length == kPieceNodes) {
        first_of_.push_back(static_cast<int>(i));
        links_.push_back(chain[i]);
        length = 0;
      }
      placed_[i].piece = static_cast<int>(first_of_.size()) - 1;
      if (length++ > 0) append(i, chain[i]);
    }
  }

  void append(std::size_t node, int edge) {
    const Placed& last = placed_[node - 1];
    const Pose motion = motion_along(edge, static_cast<int>(node));
    placed_[node].T_start_node = last.T_start_node * motion;
    const Spread spread =
        sum(last.spread(), spread_of(graph_.edges[edge], graph_.planar), motion.translation.norm());
    placed_[node].translation = static_cast<float>(spread.translation);
    placed_[node].rotation = static_cast<float>(spread.rotation);
  }

  /// Pose of a node in the one before, by an edge in either direction.
  Pose motion_along(int edge, int to) const {
    const Pose& motion = graph_.edges[edge].T_from_to;
    return ends_[edge].second == to ? motion : motion.inverse();
  }

  /// Edges between pieces, moved to their first nodes.
  void build_coarse_graph() {
    coarse_.planar = graph_.planar;
    for (std::size_t i = 0; i < first_of_.size(); ++i) {
      coarse_.nodes.push_back({static_cast<std::int64_t>(i), graph_.nodes[first_of_[i]].pose});
    }
    const auto joins_pieces = [&](const std::pair<int, int>& ends) {
      return placed_[ends.first].piece != placed_[ends.second].piece;
    };
    coarse_.edges.reserve(
        static_cast<std::size_t>(std::count_if(ends_.begin(), ends_.end(), joins_pieces)));
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      if (!joins_pieces(ends_[i])) continue;
      const Placed& from = placed_[ends_[i].first];
      const Placed& to = placed_[ends_[i].second];
      const PoseEdge& edge = graph_.edges[i];
      const Spread there =
          sum(from.spread(), spread_of(edge, graph_.planar), edge.T_from_to.translation.norm());
      const Spread back = sum(there, to.spread(), to.T_start_node.translation.norm());
      coarse_.edges.push_back({from.piece, to.piece,
                               from.T_start_node * edge.T_from_to * to.T_start_node.inverse(),
                               information_of(back, graph_.planar)});
    }
  }

  /// Nodes of a piece follow the odometry from its beginning and from that of the next one.
  void place_nodes() {
    for (std::size_t piece = 0; piece < first_of_.size(); ++piece) {
      const int begin = first_of_[piece];
      const bool is_last = piece + 1 == first_of_.size();
      const int end = is_last ? static_cast<int>(placed_.size()) : first_of_[piece + 1];
      const Pose& start = coarse_.nodes[piece].pose;
      if (is_last || links_[piece + 1] < 0) {
        for (int i = begin; i < end; ++i) place(i, start * placed_[i].T_start_node);
        continue;
      }
      const Pose T_start_end = placed_[end - 1].T_start_node * motion_along(links_[piece + 1], end);
      const Pose from_end = coarse_.nodes[piece + 1].pose * T_start_end.inverse();
      for (int i = begin; i < end; ++i) {
        const Pose& T_start_node = placed_[i].T_start_node;
        place(i, interpolate(start * T_start_node, from_end * T_start_node,
                             static_cast<double>(i - begin) / (end - begin)));
      }
    }
  }

  void place(int node, const Pose& pose) { graph_.nodes[node].pose = pose; }

  PoseGraph& graph_;
  std::vector<std::pair<int, int>> ends_;
  std::vector<Placed> placed_;
  std::vector<int> first_of_;  ///< first node of each piece
  std::vector<int> links_;     ///< edge of odometry to it; -1: none
  PoseGraph coarse_;
};

}  // namespace

bool initialize_coarsely(PoseGraph& graph, int threads) {
  return CoarseInitialization(graph).run(threads);
}

}  // namespace lidar_mapping::pose_graph
