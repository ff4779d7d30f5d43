// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/antenna_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/QR>

#include "lidar_mapping/common/path_length.hpp"

namespace lidar_mapping {

namespace {

// s. Chosen: holds a turn or a change of speed, while the drift of dead reckoning is still linear.
constexpr double kWindow = 12.0;
// Fixes in a window: 20 rows for its five unknowns and the shared ones. Chosen.
constexpr std::size_t kMinFixes = 10;
// m, path of a window; a standing vehicle gives no information. Chosen: above the noise of most
// fixes.
constexpr double kMinPathLength = 10.0;
constexpr double kNoiseFloor = 0.02;  // m; chosen: dead reckoning is no better
// Factor of the variances, because errors of neighbouring fixes are alike: so many fixes count as
// one (1 s at 10 Hz). Chosen.
constexpr double kRepetition = 10.0;
constexpr double kDelayPrior = 0.3;  // s, standard deviation; chosen: receivers are no later
// s, standard deviation from which on a delay counts as known. Chosen: 0.1 m at 15 m/s.
constexpr double kKnownSigma = 0.008;
// s; a smaller delay is not corrected. Chosen: the fit errs by nearly as much (kKnownSigma).
constexpr double kMinDelay = 0.01;
// Unknowns of a window, by definition: cos, sin, shift x, shift y, gyro bias.
constexpr int kOwn = 5;
// Unknowns of all windows, by definition: arm x, arm y, delay.
constexpr int kShared = 3;

using Rows = Eigen::Matrix<double, Eigen::Dynamic, kOwn + kShared + 1>;

Eigen::Vector2d turned_left(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// Two rows per fix: the unknowns' factors, and the right side in the last column.
Rows equations(const std::vector<TrackedFix>& window) {
  const TrackedFix& first = window.front();
  Rows rows(2 * window.size(), kOwn + kShared + 1);
  Eigen::Vector2d bent = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < window.size(); ++i) {
    const TrackedFix& fix = window[i];
    const double time = to_seconds(fix.stamp - first.stamp);
    if (i > 0) bent += time * turned_left(fix.p_dr_base - window[i - 1].p_dr_base);
    const Eigen::Matrix2d R_dr_base = Eigen::Rotation2Dd(fix.yaw_dr).toRotationMatrix();
    const Eigen::Vector2d p_enu = fix.p_enu - first.p_enu;
    const Eigen::Vector2d p_dr = fix.p_dr_base - first.p_dr_base + R_dr_base * fix.p_base_antenna;
    auto row = rows.middleRows<2>(static_cast<long>(2 * i));
    row.col(0) = p_enu;
    row.col(1) = -turned_left(p_enu);
    row.block<2, 2>(0, 2) = -Eigen::Matrix2d::Identity();
    row.col(4) = -bent;
    row.block<2, 2>(0, 5) = -R_dr_base;
    row.col(7) = fix.v_dr;
    row.col(8) = p_dr + fix.applied_delay * fix.v_dr;
  }
  return rows;
}

/// Mean square of the residuals at the least-squares solution, m^2.
double unexplained(const Rows& rows) {
  const Eigen::MatrixXd factors = rows.leftCols<kOwn + kShared>();
  const Eigen::VectorXd right = rows.col(kOwn + kShared);
  const Eigen::VectorXd solution = factors.completeOrthogonalDecomposition().solve(right);
  return (factors * solution - right).squaredNorm() / static_cast<double>(rows.rows());
}

/// The equations of the shared unknowns after the elimination of the window's own ones.
Eigen::Matrix<double, Eigen::Dynamic, kShared + 1> without_own(const Rows& rows) {
  const Eigen::MatrixXd own = rows.leftCols<kOwn>();
  const Eigen::Matrix<double, Eigen::Dynamic, kShared + 1> rest = rows.rightCols<kShared + 1>();
  return rest - own * own.completeOrthogonalDecomposition().solve(rest);
}

}  // namespace

bool AntennaFit::Result::delay_is_known() const { return delay_sigma <= kKnownSigma; }

bool AntennaFit::Result::is_late() const {
  return std::abs(delay) > std::max(kMinDelay, 4.0 * delay_sigma);
}

void AntennaFit::add(const TrackedFix& fix) {
  if (!window_.empty() && to_seconds(fix.stamp - window_.front().stamp) > kWindow) begin_window();
  window_.push_back(fix);
}

void AntennaFit::begin_window() {
  std::vector<TrackedFix> window;
  window.swap(window_);
  if (window.size() < kMinFixes) return;
  const auto position_of = [&](std::size_t i) -> const auto& { return window[i].p_dr_base; };
  if (path_length(window.size(), position_of) < kMinPathLength) return;
  const Rows rows = equations(window);
  const auto shared = without_own(rows);
  const double variance = kRepetition * (unexplained(rows) + kNoiseFloor * kNoiseFloor);
  information_ += shared.leftCols<kShared>().transpose() * shared.leftCols<kShared>() / variance;
  right_side_ += shared.leftCols<kShared>().transpose() * shared.col(kShared) / variance;
}

AntennaFit::Result AntennaFit::result(double arm_prior) const {
  const Eigen::Vector3d prior(arm_prior, arm_prior, kDelayPrior);
  const Eigen::Matrix3d information =
      information_ + prior.cwiseAbs2().cwiseInverse().asDiagonal().toDenseMatrix();
  const Eigen::Matrix3d covariance = information.inverse();
  const Eigen::Vector3d solution = covariance * right_side_;
  Result result;
  result.arm_error = solution.head<2>();
  result.arm_sigma = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  result.delay = solution(2);
  result.delay_sigma = std::sqrt(covariance(2, 2));
  return result;
}

}  // namespace lidar_mapping
