#include "lidar_mapping/back_end/shared_errors.hpp"

#include <algorithm>

#include <Eigen/Cholesky>

#include "lidar_mapping/back_end/gnss_delay.hpp"
#include "lidar_mapping/back_end/linearisation.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Of the scale of LiDAR odometry before positions show it.
constexpr double kStretchStddev = 5e-5;
/// Keeps an unknown out that nothing may change.
constexpr double kFixed = 1e-9;

enum Unknown { kStretch, kDelay, kCount };
using UnknownVector = Eigen::Matrix<double, kCount, 1>;

/// Normal equations of the unknowns at a minimum over the poses.
class SharedEquations {
 public:
  explicit SharedEquations(const FactorGraph& graph)
      : graph_(graph),
        mixed_(Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(graph.states.size()), kCount)) {}

  /// A unit of the unknown has the effect that `shift` (m) has on the constraint's last node, in
  /// the node's axes.
  void add(int constraint, Unknown unknown, const Eigen::Vector3d& shift) {
    const Constraint& c = graph_.constraints[static_cast<std::size_t>(constraint)];
    const Linearised at = linearised(graph_, c);
    const bool pair = c.second >= 0;
    const Eigen::VectorXd effect = (pair ? at.second : at.first).leftCols<3>() * shift;
    gradient_(unknown) += effect.dot(at.residual);
    curvature_(unknown, unknown) += effect.squaredNorm();
    mixed_.col(unknown).segment<6>(6 * c.first) += at.first.transpose() * effect;
    if (pair) mixed_.col(unknown).segment<6>(6 * c.second) += at.second.transpose() * effect;
  }

  /// Newton's step for unknowns that are near zero, by `stddev`.
  UnknownVector solution(BlockCholesky<6>& poses, const UnknownVector& stddev) const {
    Eigen::Matrix<double, kCount, kCount> information =
        curvature_ - mixed_.transpose() * poses.solve(mixed_);
    information.diagonal() += stddev.cwiseAbs2().cwiseInverse();
    return -information.ldlt().solve(gradient_);
  }

 private:
  const FactorGraph& graph_;
  UnknownVector gradient_ = UnknownVector::Zero();
  Eigen::Matrix<double, kCount, kCount> curvature_ = Eigen::Matrix<double, kCount, kCount>::Zero();
  Eigen::MatrixXd mixed_;
};

void add_stretch(const DriveGraph& drive, const DriveFactors& factors, SharedEquations& equations) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (factors.motion_of[i] < 0) continue;
    const int node = static_cast<int>(i);
    const Eigen::Quaterniond R_node_previous =
        factors.graph.pose(node).rotation.conjugate() * factors.graph.pose(node - 1).rotation;
    // A longer motion was measured: as if the node lay as much behind.
    equations.add(factors.motion_of[i], kStretch,
                  -(R_node_previous * motion_to(drive, i).translation));
  }
}

void add_delay(const DriveGraph& drive, const DriveFactors& factors, const std::vector<bool>& used,
               SharedEquations& equations) {
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    const int position = factors.horizontal_of[i];
    const auto segment = static_cast<std::size_t>(drive.segment_of(drive.gnss[i].node));
    if (position < 0 || !used[static_cast<std::size_t>(position)]) continue;
    if (!drive.gnss_delays[segment].is_corrected()) continue;
    equations.add(position, kDelay, -antenna_velocity(drive, drive.gnss[i]));
  }
}

double delay_stddev(const DriveGraph& drive) {
  double largest = kFixed;
  for (const GnssDelay& delay : drive.gnss_delays) {
    if (delay.is_corrected()) largest = std::max(largest, delay.sigma);
  }
  return largest;
}

}  // namespace

SharedErrors find_shared_errors(const DriveGraph& drive, const DriveFactors& factors,
                                const std::vector<bool>& used, double scatter) {
  const std::unique_ptr<BlockCholesky<6>> poses = information_matrix(factors.graph, used);
  if (!poses->factorize()) return {};
  SharedEquations equations(factors.graph);
  add_stretch(drive, factors, equations);
  add_delay(drive, factors, used, equations);
  // Covariances that are all too large by one factor leave the poses as they are, but not what they
  // are worth beside an unknown's own.
  const UnknownVector stddev = UnknownVector(kStretchStddev, delay_stddev(drive)) / scatter;
  const UnknownVector solution = equations.solution(*poses, stddev);
  return {solution(kStretch), solution(kDelay)};
}

}  // namespace lidar_mapping::back_end
