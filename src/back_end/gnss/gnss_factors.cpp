// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_factors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "gnss/gnss_delay.hpp"
#include "gnss/gnss_weights.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Factor by which the covariance of each position grows because neighbouring positions have common
/// errors.
std::vector<double> covariance_factors(const DriveGraph& drive, const BackEndConfig& config) {
  std::vector<double> factors(drive.gnss.size(), 1.0);
  const auto p_odom = [&](std::size_t i) {
    return drive.nodes[drive.gnss[i].node].T_odom_base.translation;
  };
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const std::size_t before = i == 0 ? i : i - 1;
    const std::size_t after = std::min(i + 1, factors.size() - 1);
    if (after == before) continue;
    const double spacing =
        ((p_odom(i) - p_odom(before)).norm() + (p_odom(after) - p_odom(i)).norm()) /
        static_cast<double>(after - before);
    factors[i] = std::max(1.0, config.gnss_correlation_distance / std::max(spacing, 0.1));
  }
  return factors;
}

}  // namespace

void add_gnss(const DriveGraph& drive, const BackEndConfig& config, DriveFactors& factors) {
  const std::vector<bool> in_enu = segments_in_enu(drive);
  const std::vector<double> covariance_factor = covariance_factors(drive, config);
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    const DriveGnss& gnss = drive.gnss[i];
    if (!in_enu[drive.segment_of(gnss.node)]) continue;
    const GnssPosition p = delay_corrected_position(drive, gnss);
    const auto add_switchable = [&](pose_graph::CostPtr residual) {
      pose_graph::Constraint constraint{std::move(residual), gnss.node};
      constraint.switchable = true;
      return factors.graph.add(std::move(constraint), config.gnss_robust_kernel,
                               config.robust_kernel_size);
    };
    factors.horizontal_of[i] = add_switchable(pose_graph::antenna_horizontal_residual(
        p.p_enu_antenna, p.p_base_antenna,
        covariance_factor[i] * horizontal_covariance(p, config)));
    if (!has_altitude(p)) continue;
    factors.altitude_of[i] = add_switchable(pose_graph::antenna_altitude_residual(
        p.p_enu_antenna.z(), p.p_base_antenna,
        std::sqrt(covariance_factor[i]) * altitude_stddev(p, config)));
  }
}

void add_headings(const DriveGraph& drive, const BackEndConfig& config,
                  pose_graph::FactorGraph& graph) {
  const std::vector<bool> in_enu = segments_in_enu(drive);
  for (const DriveGnss& gnss : drive.gnss) {
    if (!gnss.position.R_enu_base) continue;
    if (!in_enu[drive.segment_of(gnss.node)]) continue;
    const double yaw = yaw_of(*gnss.position.R_enu_base);
    graph.add({pose_graph::heading_residual(yaw, config.imu_heading_stddev), gnss.node},
              config.imu_robust_kernel, config.robust_kernel_size);
  }
}

}  // namespace lidar_mapping::back_end
