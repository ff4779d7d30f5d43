// SPDX-License-Identifier: BSD-3-Clause
#include "condensed/pose_graph_problem.hpp"

#include <cmath>

#include <ceres/loss_function.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pose_graph/tangent.hpp"

#include "initialization/odometry_chain.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// Relative pose of two nodes against its measurement; formulas in doc/back_end.md.
struct SpatialError {
  Eigen::Matrix3d R_b;  ///< rotation of the second node in the first
  Eigen::Vector3d t_b;
  Eigen::Matrix3d R_z;   ///< transpose of the measured rotation
  Eigen::Quaterniond q;  ///< rotation error with w >= 0
  Vector6d error;

  SpatialError(const PoseEdge& edge, const Pose& first, const Pose& second) {
    const Eigen::Quaterniond q_i = first.rotation.conjugate();
    const Eigen::Quaterniond q_b = q_i * second.rotation;
    const Eigen::Quaterniond q_z = edge.T_from_to.rotation.conjugate();
    R_b = q_b.toRotationMatrix();
    R_z = q_z.toRotationMatrix();
    t_b = q_i * (second.translation - first.translation);
    q = q_z * q_b;
    if (q.w() < 0.0) q.coeffs() *= -1.0;
    error << R_z * (t_b - edge.T_from_to.translation), q.vec();
  }
};

struct PlanarError {
  Eigen::Matrix3d first, second;  ///< derivatives
  Eigen::Vector3d error;
  Eigen::Matrix3d information;

  PlanarError(const PoseEdge& edge, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double yaw = yaw_of(edge.T_from_to.rotation);
    const Eigen::Matrix2d R_z = Eigen::Rotation2Dd(-yaw).toRotationMatrix();
    const Eigen::Matrix2d R_i = Eigen::Rotation2Dd(-a.z()).toRotationMatrix();
    const Eigen::Vector2d t_b = R_i * (b - a).head<2>();
    error << R_z * (t_b - edge.T_from_to.translation.head<2>()),
        std::remainder(b.z() - a.z() - yaw, 2.0 * kPi);
    second.setIdentity();
    second.topLeftCorner<2, 2>() = R_z * R_i;
    first = -second;
    first.topRightCorner<2, 1>() = R_z * Eigen::Vector2d(t_b.y(), -t_b.x());
    information << edge.information.topLeftCorner<2, 2>(), edge.information.block<2, 1>(0, 5),
        edge.information.block<1, 2>(5, 0), edge.information(5, 5);
  }
};

template <int size>
class PoseGraphProblem : public CondensedProblem<size> {
 public:
  PoseGraphProblem(PoseGraph& graph, RobustKernel kernel, double kernel_size)
      : graph_(graph), ends_(edge_positions(graph)), loss_(make_kernel(kernel, kernel_size)) {
    if (size == 6) return;
    for (const PoseNode& node : graph.nodes) {
      planar_.emplace_back(node.pose.translation.x(), node.pose.translation.y(),
                           yaw_of(node.pose.rotation));
    }
  }

  int node_count() const override { return static_cast<int>(graph_.nodes.size()); }
  int factor_count() const override { return static_cast<int>(ends_.size()); }
  std::pair<int, int> nodes_of(int factor) const override { return ends_[factor]; }
  bool is_fixed(int node) const override { return node == 0; }

  double cost(int factor) const override {
    const auto [first, second] = ends_[factor];
    const PoseEdge& edge = graph_.edges[factor];
    if constexpr (size == 6) {
      const SpatialError e(edge, pose(first), pose(second));
      return loss_at(loss_of(edge), e.error.dot(edge.information * e.error)).first;
    } else {
      const PlanarError e(edge, planar_[first], planar_[second]);
      return loss_at(loss_of(edge), e.error.dot(e.information * e.error)).first;
    }
  }

  void linearise(int factor, FactorBlocks<size>& blocks) const override {
    const auto [first, second] = ends_[factor];
    const PoseEdge& edge = graph_.edges[factor];
    if constexpr (size == 6) {
      linearise_spatial(edge, pose(first), pose(second), blocks);
    } else {
      linearise_planar(edge, planar_[first], planar_[second], blocks);
    }
  }

  void apply(const std::vector<int>& nodes, const Eigen::VectorXd& step) override {
    before_.clear();
    before_.reserve(nodes.size());
    moved_ = nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const double* d = step.data() + static_cast<std::ptrdiff_t>(size * i);
      if constexpr (size == 6) {
        Pose& pose = graph_.nodes[nodes[i]].pose;
        before_.push_back(to_block(pose));
        pose = to_pose(retract(before_.back().data(), d).data());
      } else {
        Eigen::Vector3d& state = planar_[nodes[i]];
        before_.push_back({state.x(), state.y(), state.z(), 0.0, 0.0, 0.0, 0.0});
        state += Eigen::Map<const Eigen::Vector3d>(d);
        set_planar_pose(nodes[i]);
      }
    }
  }

  void restore() override {
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      if constexpr (size == 6) {
        graph_.nodes[moved_[i]].pose = to_pose(before_[i].data());
      } else {
        planar_[moved_[i]] = Eigen::Map<const Eigen::Vector3d>(before_[i].data());
        set_planar_pose(moved_[i]);
      }
    }
  }

 private:
  const Pose& pose(int node) const { return graph_.nodes[node].pose; }

  void set_planar_pose(int node) { graph_.nodes[node].pose = to_planar_pose(planar_[node].data()); }

  const ceres::LossFunction* loss_of(const PoseEdge& edge) const {
    return is_odometry(edge) ? nullptr : loss_.get();
  }

  /// By the second node the derivatives are block diagonal; those by the first are these times the
  /// adjoint of the relative pose, which saves most of the products.
  void linearise_spatial(const PoseEdge& edge, const Pose& first, const Pose& second,
                         FactorBlocks<size>& blocks) const {
    const SpatialError e(edge, first, second);
    Matrix6d information = edge.information;
    Vector6d pull = information * e.error;
    const double weight = loss_at(loss_of(edge), e.error.dot(pull)).second;
    if (weight != 1.0) {
      information *= weight;
      pull *= weight;
    }
    const Eigen::Matrix3d P = e.R_z * e.R_b;
    const Eigen::Matrix3d W = e.q.w() * Eigen::Matrix3d::Identity() + skew(e.q.vec());
    const Eigen::Matrix3d tt_P = information.topLeftCorner<3, 3>() * P;
    const Eigen::Matrix3d tr_W = information.topRightCorner<3, 3>() * W;
    const Eigen::Matrix3d rr_W = information.bottomRightCorner<3, 3>() * W;
    const Eigen::Matrix3d tt = P.transpose() * tt_P;
    const Eigen::Matrix3d tr = P.transpose() * tr_W;
    const Eigen::Matrix3d rr = W.transpose() * rr_W;
    blocks.second << tt, tr, tr.transpose(), rr;
    // A = [R^T, -2 R^T [t]x; 0, R^T], and so A^T = [R, 0; X, R].
    const Eigen::Matrix3d& R = e.R_b;
    const Eigen::Matrix3d X = 2.0 * (skew(e.t_b) * R);
    const Eigen::Matrix3d cross_tt = R * tt;
    const Eigen::Matrix3d cross_tr = R * tr;
    Eigen::Matrix3d cross_rt = X * tt;
    cross_rt.noalias() += R * tr.transpose();
    Eigen::Matrix3d cross_rr = X * tr;
    cross_rr.noalias() += R * rr;
    blocks.cross << -cross_tt, -cross_tr, -cross_rt, -cross_rr;
    const Eigen::Matrix3d first_tt = cross_tt * R.transpose();
    Eigen::Matrix3d first_tr = cross_tt * X.transpose();
    first_tr.noalias() += cross_tr * R.transpose();
    Eigen::Matrix3d first_rr = cross_rt * X.transpose();
    first_rr.noalias() += cross_rr * R.transpose();
    blocks.first << first_tt, first_tr, first_tr.transpose(), first_rr;
    blocks.second_gradient << P.transpose() * pull.head<3>(), W.transpose() * pull.tail<3>();
    const Vector6d& g = blocks.second_gradient;
    blocks.first_gradient << -(R * g.head<3>()), -(R * g.tail<3>()) - X * g.head<3>();
  }

  void linearise_planar(const PoseEdge& edge, const Eigen::Vector3d& first,
                        const Eigen::Vector3d& second, FactorBlocks<size>& blocks) const {
    const PlanarError e(edge, first, second);
    const double weight = loss_at(loss_of(edge), e.error.dot(e.information * e.error)).second;
    const Eigen::Matrix3d information = weight * e.information;
    const Eigen::Matrix3d by_first = e.first.transpose() * information;
    const Eigen::Matrix3d by_second = e.second.transpose() * information;
    blocks.first = by_first * e.first;
    blocks.second = by_second * e.second;
    blocks.cross = by_first * e.second;
    blocks.first_gradient = by_first * e.error;
    blocks.second_gradient = by_second * e.error;
  }

  PoseGraph& graph_;
  std::vector<std::pair<int, int>> ends_;
  std::unique_ptr<ceres::LossFunction> loss_;  ///< of loops; null for least squares
  std::vector<Eigen::Vector3d> planar_;        ///< x y yaw, not wrapped; empty for poses in space
  std::vector<int> moved_;                     ///< by the last step
  std::vector<StateBlock> before_;             ///< states of these before the step
};

}  // namespace

template <int size>
std::unique_ptr<CondensedProblem<size>> make_condensed_problem(PoseGraph& graph,
                                                               RobustKernel kernel,
                                                               double kernel_size) {
  return std::make_unique<PoseGraphProblem<size>>(graph, kernel, kernel_size);
}

template std::unique_ptr<CondensedProblem<3>> make_condensed_problem<3>(PoseGraph&, RobustKernel,
                                                                        double);
template std::unique_ptr<CondensedProblem<6>> make_condensed_problem<6>(PoseGraph&, RobustKernel,
                                                                        double);

}  // namespace lidar_mapping::pose_graph
