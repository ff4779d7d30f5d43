#include "cell_statistics.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::map {

Plane plane_of(const Moments& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments.covariance());
  const Eigen::Vector3d spreads = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return {solver.eigenvectors().col(0), moments.mean(), spreads[0], spreads[1]};
}

std::int64_t cell_key(const Eigen::Vector3d& point, double size) {
  const auto part = [&](double value) {
    return static_cast<std::int64_t>(std::floor(value / size)) & 0x1FFFFF;
  };
  return part(point.x()) << 42 | part(point.y()) << 21 | part(point.z());
}

}  // namespace lidar_mapping::map
