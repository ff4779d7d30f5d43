// SPDX-License-Identifier: BSD-3-Clause
// A pose graph with a factor of one's own: ranges to radio beacons correct an odometry that drifts.
//   own_factor

#include <cstdio>

#include <ceres/sized_cost_function.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pose_graph/factor_graph.hpp"

namespace {

using namespace lidar_mapping;
using namespace lidar_mapping::pose_graph;

/// Residual of a measured range between a node and a beacon in the map, in standard deviations.
/// Derivatives are with respect to the update of tangent.hpp, (dt, v) in the axes of the node.
class RangeToBeacon : public ceres::SizedCostFunction<1, kPoseBlockSize> {
 public:
  RangeToBeacon(const Eigen::Vector3d& p_map_beacon, double range_m, double stddev_m)
      : p_map_beacon_(p_map_beacon), range_m_(range_m), stddev_m_(stddev_m) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Pose T_map_base = to_pose(blocks[0]);
    const Eigen::Vector3d ray = T_map_base.translation - p_map_beacon_;
    residual[0] = (ray.norm() - range_m_) / stddev_m_;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 1, kPoseBlockSize>> jacobian(jacobians[0]);
    jacobian.setZero();  // turning the node about its own origin changes no range
    jacobian.head<3>() = ray.normalized().transpose() * T_map_base.rotation_matrix() / stddev_m_;
    return true;
  }

 private:
  Eigen::Vector3d p_map_beacon_;
  double range_m_, stddev_m_;
};

constexpr int kNodes = 80;

/// Two rounds on a circle with a radius of 20 m.
Pose true_pose(int node) {
  const double angle = 4.0 * M_PI * node / kNodes;
  return {exp_so3({0.0, 0.0, angle + M_PI / 2.0}),
          {20.0 * std::cos(angle), 20.0 * std::sin(angle), 0.0}};
}

double rmse(const FactorGraph& graph) {
  double sum = 0.0;
  for (int i = 0; i < kNodes; ++i) {
    sum += (graph.pose(i).translation - true_pose(i).translation).squaredNorm();
  }
  return std::sqrt(sum / kNodes);
}

}  // namespace

int main() {
  // Each measured step is 1 % too long and turns 0.2 degrees too far.
  const Matrix6d information = g2o_information(diagonal_covariance(0.05, 0.005));
  const Eigen::Vector3d beacons[] = {{30.0, 0.0, 5.0}, {-20.0, 30.0, 2.0}, {-20.0, -30.0, 8.0}};
  FactorGraph graph;
  graph.add_node(true_pose(0), true);  // held: it does not move
  for (int i = 1; i < kNodes; ++i) {
    Pose step = true_pose(i - 1).inverse() * true_pose(i);
    step = {step.rotation * exp_so3({0.0, 0.0, 0.2 * kRadPerDeg}), 1.01 * step.translation};
    graph.add_node(graph.pose(i - 1) * step);
    graph.add({relative_pose_residual(step, information), i - 1, i});
    for (const Eigen::Vector3d& beacon : beacons) {
      const double range = (true_pose(i).translation - beacon).norm();
      graph.add({std::make_unique<RangeToBeacon>(beacon, range, 0.1), i});
    }
  }
  const double before = rmse(graph);
  const std::vector<bool> all(graph.constraints.size(), true);
  const auto summary = minimize(graph, all, [](const Constraint&) { return nullptr; }, {});
  std::printf("%zu constraints, %d iterations, chi2 %.1f to %.1f\n", graph.constraints.size(),
              summary.iterations, summary.initial_cost, summary.final_cost);
  std::printf("position error %.3f m before, %.3f m after\n", before, rmse(graph));
  return summary.usable ? 0 : 1;
}
