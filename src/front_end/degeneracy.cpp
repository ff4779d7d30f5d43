#include "lidar_mapping/front_end/degeneracy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace lidar_mapping::front_end {
namespace {

using registration::Matrix12d;
using registration::Vector12d;

/// A share of the trace: a smooth tunnel has less than 0.0006, an open field more than 0.004.
constexpr double kMinShare = 0.0015;

}  // namespace

std::vector<Eigen::Vector3d> degenerate_directions(const Matrix6d& pose_hessian) {
  const Eigen::Matrix3d H = pose_hessian.topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(H);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < 3; ++i) {
    if (solver.eigenvalues()[i] > kMinShare * H.trace()) break;
    directions.emplace_back(solver.eigenvectors().col(i));
  }
  return directions;
}

registration::NdtMatch without_directions(const registration::NdtMatch& match,
                                          const registration::MotionBelief& matched_with,
                                          const registration::MotionBelief& instead,
                                          const std::vector<Eigen::Vector3d>& directions) {
  Matrix12d keep = Matrix12d::Identity();
  for (const Eigen::Vector3d& direction : directions) {
    const Eigen::Matrix3d along = direction * direction.transpose();
    keep.block<3, 3>(0, 0) -= along;
    keep.block<3, 3>(6, 6) -= along;
  }
  // At the match the points' gradient balances that of the prior. With less of the one and more of
  // the other, one step of Gauss-Newton finds the new balance.
  const Vector12d points_gradient =
      -matched_with.information * difference(matched_with.state, match.state);
  const Vector12d prior_gradient = instead.information * difference(instead.state, match.state);
  registration::NdtMatch result = match;
  result.points_information = keep * match.points_information * keep;
  result.information = result.points_information + instead.information;
  const Vector12d step = -result.information.ldlt().solve(keep * points_gradient + prior_gradient);
  result.state = perturbed(match.state, step);
  return result;
}

}  // namespace lidar_mapping::front_end
