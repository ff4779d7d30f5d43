// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_delay.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lidar_mapping/common/antenna_fit.hpp"

namespace lidar_mapping::back_end {

namespace {

// s, least standard deviation of the delay. Chosen: a longer drive does not make it more certain,
// since the delay itself varies.
constexpr double kMinSigma = 0.003;
constexpr Stamp kWindowDuration = from_seconds(12.0);
// Seconds between key frames; without motion there is no velocity. Chosen: a longer step says less
// about the velocity in its middle.
constexpr double kMaxStepDuration = 2.0;

/// Position (m) and velocity (m/s) of the antenna in the axes of one base_link.
struct AntennaState {
  Eigen::Vector3d position;
  Eigen::Vector3d velocity;
};

/// Number of key frames on each side of a time through which the path of the antenna is
/// interpolated. Measured at a delay of 50 ms: through four key frames it is off by 0.5 to 0.8 mm,
/// with an even change of the speed from step to step by 4 to 5 mm.
constexpr int kKeyFramesPerSide = 2;

/// The polynomial through positions at given times (Newton's divided differences).
class TrajectoryPolynomial {
 public:
  void add(double seconds, const Eigen::Vector3d& position) {
    seconds_.push_back(seconds);
    std::vector<Eigen::Vector3d> differences = {position};
    for (std::size_t i = 0; i < last_differences_.size(); ++i) {
      const double span = seconds - seconds_[last_differences_.size() - 1 - i];
      differences.push_back((differences[i] - last_differences_[i]) / span);
    }
    coefficients_.push_back(differences.back());
    last_differences_ = std::move(differences);
  }

  AntennaState at(double seconds) const {
    AntennaState result{coefficients_.back(), Eigen::Vector3d::Zero()};
    for (std::size_t i = coefficients_.size() - 1; i-- > 0;) {
      const double since = seconds - seconds_[i];
      result.velocity = result.position + since * result.velocity;
      result.position = coefficients_[i] + since * result.position;
    }
    return result;
  }

 private:
  std::vector<double> seconds_;
  std::vector<Eigen::Vector3d> coefficients_;
  /// Divided differences that end at the last position.
  std::vector<Eigen::Vector3d> last_differences_;
};

double seconds_between(const DriveGraph& drive, int from, int to) {
  return to_seconds(drive.nodes[to].stamp - drive.nodes[from].stamp);
}

/// True if odometry connects a node with the next one without a stop between them.
bool moves_to_next(const DriveGraph& drive, int node) {
  if (node < 0 || node + 1 >= static_cast<int>(drive.nodes.size())) return false;
  if (!drive.nodes[node + 1].connected) return false;
  const double seconds = seconds_between(drive, node, node + 1);
  return seconds > 0.0 && seconds <= kMaxStepDuration;
}

/// State of the antenna `delay` seconds before the stamp of a node, in the base_link of that node,
/// interpolated between key frames by odometry.
AntennaState antenna_at_delay(const DriveGraph& drive, int node, const Eigen::Vector3d& lever_arm,
                              double delay) {
  int before = node;
  while (moves_to_next(drive, before - 1) && seconds_between(drive, node, before) > -delay)
    --before;
  while (moves_to_next(drive, before) && seconds_between(drive, node, before + 1) <= -delay)
    ++before;
  int first = before;
  while (first > before + 1 - kKeyFramesPerSide && moves_to_next(drive, first - 1)) --first;
  int last = before;
  while (last < before + kKeyFramesPerSide && moves_to_next(drive, last)) ++last;
  const Pose T_node_odom = drive.nodes[node].T_odom_base.inverse();
  TrajectoryPolynomial polynomial;
  for (int i = first; i <= last; ++i) {
    const Pose T_node_there = T_node_odom * drive.nodes[i].T_odom_base;
    polynomial.add(seconds_between(drive, node, i),
                   i == node ? lever_arm : T_node_there * lever_arm);
  }
  return polynomial.at(-delay);
}

const DriveNode& node_of(const DriveGraph& drive, const DriveGnss& gnss) {
  return drive.nodes[gnss.node];
}

Eigen::Quaterniond R_map_odom(const DriveNode& node) {
  return node.T_map_base.rotation * node.T_odom_base.rotation.conjugate();
}

/// A fix together with the pose of its node by odometry, in a frame with a vertical z axis.
TrackedFix tracked_fix(const DriveGraph& drive, const DriveGnss& gnss,
                       const Eigen::Quaterniond& R_level_odom) {
  const DriveNode& node = node_of(drive, gnss);
  const Eigen::Vector3d& lever_arm = gnss.position.p_base_antenna;
  const Eigen::Quaterniond R_level_base = R_level_odom * node.T_odom_base.rotation;
  TrackedFix fix;
  fix.stamp = node.stamp;
  fix.p_enu = gnss.position.p_enu_antenna.head<2>();
  fix.yaw_dr = yaw_of(R_level_base);
  fix.p_dr_base = (R_level_odom * node.T_odom_base.translation).head<2>();
  fix.v_dr = (R_level_base * antenna_at_delay(drive, gnss.node, lever_arm, 0.0).velocity).head<2>();
  fix.p_base_antenna = lever_arm.head<2>();
  return fix;
}

struct DelayFits {
  AntennaFit all_segments;
  std::vector<AntennaFit> per_segment;
};

/// Fits the fixes to odometry in windows that are short enough for its drift.
DelayFits fit_delays(const DriveGraph& drive) {
  DelayFits fits;
  Eigen::Quaterniond R_level_odom = Eigen::Quaterniond::Identity();
  int segment = -1;
  Stamp begin = 0;
  fits.per_segment.resize(drive.in_enu.size());
  for (const DriveGnss& gnss : drive.gnss) {
    const DriveNode& node = node_of(drive, gnss);
    if (node.segment != segment || node.stamp - begin > kWindowDuration) {
      fits.all_segments.begin_window();
      if (segment >= 0) fits.per_segment[segment].begin_window();
      R_level_odom = R_map_odom(node);
      segment = node.segment;
      begin = node.stamp;
    }
    const TrackedFix fix = tracked_fix(drive, gnss, R_level_odom);
    fits.all_segments.add(fix);
    fits.per_segment[segment].add(fix);
  }
  fits.all_segments.begin_window();
  for (AntennaFit& fit : fits.per_segment) fit.begin_window();
  return fits;
}

/// A delay that is not certain yet is not corrected, but is included in the uncertainty.
GnssDelay delay_of(const AntennaFit::Result& result) {
  if (!result.delay_is_known()) {
    return {0.0, std::min(GnssDelay{}.sigma, std::hypot(result.delay, result.delay_sigma))};
  }
  const double sigma = std::max(kMinSigma, result.delay_sigma);
  if (!result.is_late()) return {0.0, sigma};
  return {result.delay, sigma, result.arm_error};
}

}  // namespace

void estimate_gnss_delays(DriveGraph& drive, const BackEndConfig& config) {
  if (!config.estimate_gnss_time_offset || drive.gnss.empty()) return;
  const DelayFits fits = fit_delays(drive);
  for (std::size_t i = 0; i < fits.per_segment.size(); ++i) {
    const AntennaFit::Result segment_result = fits.per_segment[i].result();
    drive.gnss_delays[i] =
        delay_of(segment_result.delay_is_known() ? segment_result : fits.all_segments.result());
  }
}

Eigen::Vector3d antenna_velocity(const DriveGraph& drive, const DriveGnss& gnss) {
  const auto segment = static_cast<std::size_t>(node_of(drive, gnss).segment);
  return antenna_at_delay(drive, gnss.node, gnss.position.p_base_antenna,
                          drive.gnss_delays[segment].seconds)
      .velocity;
}

GnssPosition delay_corrected_position(const DriveGraph& drive, const DriveGnss& gnss) {
  const DriveNode& node = node_of(drive, gnss);
  const auto segment = static_cast<std::size_t>(node.segment);
  const GnssDelay& delay = drive.gnss_delays[segment];
  GnssPosition position = gnss.position;
  position.p_base_antenna.head<2>() += delay.arm_error;
  const AntennaState antenna =
      antenna_at_delay(drive, gnss.node, position.p_base_antenna, delay.seconds);
  position.p_base_antenna = antenna.position;
  const Eigen::Vector2d displacement =
      delay.sigma * (node.T_map_base.rotation * antenna.velocity).head<2>();
  position.covariance.topLeftCorner<2, 2>() +=
      drive.in_enu[segment]
          ? Eigen::Matrix2d(displacement * displacement.transpose())
          : Eigen::Matrix2d(displacement.squaredNorm() * Eigen::Matrix2d::Identity());
  return position;
}

}  // namespace lidar_mapping::back_end
