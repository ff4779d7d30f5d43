// SPDX-License-Identifier: BSD-3-Clause
#include "initialization/chordal_initialization.hpp"

#include <memory>
#include <numeric>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "lidar_mapping/pose_graph/block_cholesky.hpp"

#include "initialization/odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// An edge in d dimensions.
template <int d>
struct ChordalEdge {
  int from = 0;  ///< number of the node among the unknowns; -1 for the first node, which is fixed
  int to = 0;
  Eigen::Matrix<double, d, d> R;
  Eigen::Matrix<double, d, 1> t;
  Eigen::Matrix<double, d, d> translation_information;
  double rotation_weight = 1.0;
};

template <int d>
ChordalEdge<d> chordal_edge(const PoseEdge& edge, const std::pair<int, int>& ends) {
  ChordalEdge<d> result;
  result.from = ends.first - 1;
  result.to = ends.second - 1;
  result.R = edge.T_from_to.rotation_matrix().template topLeftCorner<d, d>();
  result.t = edge.T_from_to.translation.head<d>();
  result.translation_information = edge.information.topLeftCorner<d, d>();
  const Eigen::Matrix3d rotation_information = edge.information.bottomRightCorner<3, 3>();
  result.rotation_weight =
      d == 2 ? edge.information(5, 5) : 3.0 / rotation_information.inverse().trace();
  return result;
}

Eigen::Matrix2d nearest_rotation(const Eigen::Matrix2d& M) {
  const double angle = std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1));
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

template <int d>
class ChordalInitialization {
 public:
  using Block = Eigen::Matrix<double, d, d>;

  explicit ChordalInitialization(PoseGraph& graph)
      : graph_(graph), nodes_(static_cast<int>(graph.nodes.size()) - 1) {
    const auto ends = edge_positions(graph);
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      edges_.push_back(chordal_edge<d>(graph.edges[i], ends[i]));
      pair_of_.push_back(-1);
      if (edges_[i].from < 0 || edges_[i].to < 0) continue;
      pair_of_.back() = static_cast<int>(pairs.size());
      pairs.emplace_back(edges_[i].from, edges_[i].to);
    }
    system_ = std::make_unique<BlockCholesky<d>>(nodes_, pairs);
  }

  bool run() {
    const Pose first = graph_.nodes.front().pose;
    if (!solve_rotations() || !solve_translations()) return false;
    for (std::size_t i = 0; i < graph_.nodes.size(); ++i) {
      graph_.nodes[i].pose = first * pose(static_cast<int>(i) - 1);
    }
    return true;
  }

 private:
  /// Minimises sum w |M_to - R^T M_from|^2 over M = R_node^T, with M = I at the first node.
  bool solve_rotations() {
    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(nodes_ * d, d);
    system_->set_zero();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const ChordalEdge<d>& e = edges_[i];
      const Block diagonal = e.rotation_weight * Block::Identity();
      const Block cross = -e.rotation_weight * e.R;
      add(i, diagonal, diagonal, cross);
      if (e.to < 0) rhs.template middleRows<d>(e.from * d) -= cross;
      if (e.from < 0) rhs.template middleRows<d>(e.to * d) -= cross.transpose();
    }
    if (!system_->factorize()) return false;
    const Eigen::MatrixXd solved = system_->solve(rhs);
    rotations_.resize(static_cast<std::size_t>(nodes_));
    for (int node = 0; node < nodes_; ++node) {
      const Block M = solved.template middleRows<d>(node * d);
      rotations_[node] = nearest_rotation(Block(M.transpose()));
    }
    return true;
  }

  /// With fixed rotations the cost is quadratic in the translations.
  bool solve_translations() {
    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(nodes_ * d, 1);
    system_->set_zero();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const ChordalEdge<d>& e = edges_[i];
      const Block R_from = rotation(e.from);
      const Block C = R_from * e.R;
      const Block A = C * e.translation_information * C.transpose();
      add(i, A, A, -A);
      const Eigen::Matrix<double, d, 1> pull = A * R_from * e.t;
      if (e.from >= 0) rhs.template middleRows<d>(e.from * d) -= pull;
      if (e.to >= 0) rhs.template middleRows<d>(e.to * d) += pull;
    }
    if (!system_->factorize()) return false;
    translations_ = system_->solve(rhs);
    return true;
  }

  void add(std::size_t edge, const Block& at_from, const Block& at_to, const Block& between) {
    const ChordalEdge<d>& e = edges_[edge];
    if (e.from >= 0) system_->add_diagonal(e.from, at_from);
    if (e.to >= 0) system_->add_diagonal(e.to, at_to);
    if (pair_of_[edge] >= 0) system_->add_pair(static_cast<std::size_t>(pair_of_[edge]), between);
  }

  Block rotation(int unknown) const {
    return unknown < 0 ? Block::Identity() : rotations_[unknown];
  }

  Pose pose(int unknown) const {
    if (unknown < 0) return Pose::Identity();
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<d, d>() = rotation(unknown);
    Pose pose;
    pose.rotation = Eigen::Quaterniond(R).normalized();
    pose.translation.head<d>() = translations_.template middleRows<d>(unknown * d);
    return pose;
  }

  PoseGraph& graph_;
  int nodes_;
  std::vector<ChordalEdge<d>> edges_;
  std::vector<int> pair_of_;
  std::unique_ptr<BlockCholesky<d>> system_;
  std::vector<Block> rotations_;
  Eigen::MatrixXd translations_;
};

/// True if edges lead from each node to all others.
bool is_connected(const PoseGraph& graph) {
  std::vector<std::size_t> parent(graph.nodes.size());  // of the trees of connected nodes
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root_of = [&](int node) {
    auto root = static_cast<std::size_t>(node);
    while (parent[root] != root) root = parent[root] = parent[parent[root]];
    return root;
  };
  std::size_t trees = parent.size();
  for (const auto& [from, to] : edge_positions(graph)) {
    const std::size_t a = root_of(from), b = root_of(to);
    if (a == b) continue;
    parent[a] = b;
    --trees;
  }
  return trees == 1;
}

}  // namespace

bool initialize_chordally(PoseGraph& graph) {
  if (graph.nodes.size() < 2) return true;
  // Rounding may hide that the equations of an unconnected graph are singular.
  if (!is_connected(graph)) return false;
  return graph.planar ? ChordalInitialization<2>(graph).run()
                      : ChordalInitialization<3>(graph).run();
}

}  // namespace lidar_mapping::pose_graph
