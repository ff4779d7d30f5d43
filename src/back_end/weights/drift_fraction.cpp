// SPDX-License-Identifier: BSD-3-Clause
#include "weights/drift_fraction.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Lower bounds of the fraction of the configured drift (chosen: a few minutes of good agreement do
/// not prove that the odometry is perfect) and of the scatter (chosen above zero: a divisor).
constexpr double kMinFraction = 0.1;
constexpr double kMinScatter = 1e-3;
/// Least number of sections for a mean square (chosen: its root is good to a quarter), and least
/// length in motions of the longest sections (chosen so that errors that neighbouring motions have
/// in common are seen).
constexpr std::size_t kMinSections = 8;
constexpr std::size_t kMinLongestSection = 16;

/// Cumulative sums along the path; the sum over a section is the difference of two entries.
struct CumulativeSums {
  /// Of the motions up to each node, in units of the configured drift.
  std::vector<Vector6d> errors;
  std::vector<int> positions;  ///< number of nodes with a used position up to each node
  /// First node of the section of odometry that each node belongs to.
  std::vector<std::size_t> begin;
};

Vector6d motion_error(const DriveGraph& drive, const BackEndConfig& config,
                      const pose_graph::FactorGraph& graph, std::size_t node) {
  const Pose measured = motion_to(drive, node);
  const int to = static_cast<int>(node);
  const Pose error_pose = measured.inverse() * graph.pose(to - 1).inverse() * graph.pose(to);
  Vector6d error;
  error << error_pose.translation, log_so3(error_pose.rotation);
  return error.cwiseQuotient(drift_stddev(measured, config));
}

CumulativeSums cumulative_sums(const DriveGraph& drive, const BackEndConfig& config,
                               const DriveFactors& factors, const std::vector<bool>& used) {
  std::vector<int> has_position(drive.nodes.size(), 0);
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    if (!is_used(factors.horizontal_of[i], used)) continue;
    has_position[drive.gnss[i].node] = 1;
  }
  CumulativeSums sums;
  Vector6d errors = Vector6d::Zero();
  int positions = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (factors.motion_of[i] < 0) {
      begin = i;
    } else if (!drive.nodes[i].doubtful) {  // the error of a doubtful step is not drift
      errors += motion_error(drive, config, factors.graph, i);
    }
    positions += has_position[i];
    sums.errors.push_back(errors);
    sums.positions.push_back(positions);
    sums.begin.push_back(begin);
  }
  return sums;
}

/// The variance of the error of one motion, if the errors of the motions in each section of
/// `length` motions were independent. Empty if there are too few sections with positions at half of
/// their nodes.
std::optional<Vector6d> motion_variance(const CumulativeSums& sums, std::size_t length) {
  Vector6d squares = Vector6d::Zero();
  std::size_t count = 0;
  for (std::size_t end = length; end < sums.errors.size(); end += length) {
    const std::size_t begin = end - length;
    const int positions = sums.positions[end] - sums.positions[begin];
    if (sums.begin[end] > begin || 2 * positions < static_cast<int>(length)) continue;
    squares += (sums.errors[end] - sums.errors[begin]).cwiseAbs2();
    ++count;
  }
  if (count < kMinSections) return std::nullopt;
  return Vector6d(squares / static_cast<double>(count * length));
}

}  // namespace

double position_scatter(const DriveFactors& factors, const std::vector<bool>& used) {
  double squares = 0.0;
  int dof = 0;
  for (const int i : factors.horizontal_of) {
    if (!is_used(i, used)) continue;
    const pose_graph::Constraint& position = factors.graph.constraints[i];
    squares += pose_graph::chi2(factors.graph, position);
    dof += position.degrees_of_freedom();
  }
  return dof == 0 ? 1.0 : std::clamp(std::sqrt(squares / dof), kMinScatter, 1.0);
}

Vector6d observed_drift_fraction(const DriveGraph& drive, const BackEndConfig& config,
                                 const DriveFactors& factors, const std::vector<bool>& used) {
  if (config.use_const_inf_matrix) return Vector6d::Ones();
  const CumulativeSums sums = cumulative_sums(drive, config, factors, used);
  Vector6d variance = Vector6d::Zero();
  std::size_t length = 1;
  for (;; length *= 2) {
    const auto section_variance = motion_variance(sums, length);
    if (!section_variance) break;
    variance = variance.cwiseMax(*section_variance);
  }
  if (length <= kMinLongestSection) return Vector6d::Ones();
  return (variance.cwiseSqrt() / position_scatter(factors, used))
      .cwiseMax(kMinFraction)
      .cwiseMin(1.0);
}

}  // namespace lidar_mapping::back_end
