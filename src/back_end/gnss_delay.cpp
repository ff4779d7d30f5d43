#include "lidar_mapping/back_end/gnss_delay.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lidar_mapping/common/antenna_fit.hpp"

namespace lidar_mapping::back_end {

namespace {

constexpr double kLeastSigma = 0.003;  // s
constexpr Stamp kWindow = from_seconds(12.0);
constexpr double kLongestStep = 2.0;  // s between key frames; a vehicle that stood tells no speed

/// Velocities of base_link in its own axes.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();

  Twist plus(const Twist& other, double factor) const {
    return {linear + factor * other.linear, angular + factor * other.angular};
  }
};

/// That leads by T_start_end on an even arc.
Twist twist_over(const Pose& T_start_end, double seconds) {
  const Eigen::Vector3d turn = log_so3(T_start_end.rotation);
  const Eigen::Vector3d chord = T_start_end.translation;
  const Eigen::Vector3d arc =
      chord - 0.5 * turn.cross(chord) + turn.cross(turn.cross(chord)) / 12.0;
  return {arc / seconds, turn / seconds};
}

/// `p_base` is where such a motion of `seconds` brings a point of base_link.
Eigen::Vector3d moved(const Eigen::Vector3d& p_base, const Twist& twist, double seconds) {
  const Eigen::Vector3d arc = twist.linear * seconds;
  const Eigen::Vector3d turn = twist.angular * seconds;
  return exp_so3(turn) * p_base + arc + 0.5 * turn.cross(arc);
}

/// The motion about a key frame: the twist after s seconds is twist + change s.
struct Motion {
  Twist twist;
  Twist change;
};

struct Step {
  double seconds;
  Twist twist;
};

/// From one node to its neighbour, before it or after.
std::optional<Step> step_to(const DriveGraph& drive, int node, int neighbour) {
  const int later = std::max(node, neighbour);
  if (std::min(node, neighbour) < 0 || later >= static_cast<int>(drive.nodes.size()) ||
      !drive.nodes[static_cast<std::size_t>(later)].joined) {
    return std::nullopt;
  }
  const DriveNode& here = drive.nodes[static_cast<std::size_t>(node)];
  const DriveNode& there = drive.nodes[static_cast<std::size_t>(neighbour)];
  const double seconds = to_seconds(there.stamp - here.stamp);
  if (seconds == 0.0 || std::abs(seconds) > kLongestStep) return std::nullopt;
  return Step{seconds, twist_over(here.T_odom_base.inverse() * there.T_odom_base, seconds)};
}

/// Through the key frames before and after as odometry has them; even with one of them, at rest
/// without.
Motion motion_at(const DriveGraph& drive, int node) {
  const auto before = step_to(drive, node, node - 1);
  const auto after = step_to(drive, node, node + 1);
  if (!before || !after) return {before ? before->twist : after ? after->twist : Twist{}, {}};
  // Each mean is the twist in the middle of its step.
  const double apart = 0.5 * (after->seconds - before->seconds);
  const Twist gain = after->twist.plus(before->twist, -1.0);
  const Twist change{gain.linear / apart, gain.angular / apart};
  return {after->twist.plus(change, -0.5 * after->seconds), change};
}

Eigen::Vector3d antenna_velocity(const Motion& motion, const Eigen::Vector3d& arm) {
  return motion.twist.linear + motion.twist.angular.cross(arm);
}

const DriveNode& node_of(const DriveGraph& drive, const DriveGnss& gnss) {
  return drive.nodes[static_cast<std::size_t>(gnss.node)];
}

Eigen::Quaterniond R_map_odom(const DriveNode& node) {
  return node.T_map_base.rotation * node.T_odom_base.rotation.conjugate();
}

/// Where the antenna was `delay` seconds before, in base_link as it is at the node.
Eigen::Vector3d arm_before(const Motion& motion, const Eigen::Vector3d& arm, double delay) {
  return moved(arm, motion.twist.plus(motion.change, -0.5 * delay), -delay);
}

/// Odometry at a node beside its fix, in axes that are level.
TrackedFix tracked_fix(const DriveGraph& drive, const DriveGnss& gnss,
                       const Eigen::Quaterniond& R_level_odom) {
  const DriveNode& node = node_of(drive, gnss);
  const Motion motion = motion_at(drive, gnss.node);
  const Eigen::Vector3d& arm = gnss.position.p_base_antenna;
  const Eigen::Quaterniond R_level_base = R_level_odom * node.T_odom_base.rotation;
  TrackedFix fix;
  fix.stamp = node.stamp;
  fix.p_enu = gnss.position.p_enu_antenna.head<2>();
  fix.yaw_dr = yaw_of(R_level_base);
  fix.p_dr_base = (R_level_odom * node.T_odom_base.translation).head<2>();
  fix.v_dr = (R_level_base * antenna_velocity(motion, arm)).head<2>();
  fix.p_base_antenna = arm.head<2>();
  return fix;
}

struct DelayFits {
  AntennaFit common;
  std::vector<AntennaFit> of_segment;
};

/// Lays the fixes over odometry, in windows over which its drift does not add up.
DelayFits fits_of(const DriveGraph& drive) {
  DelayFits fits;
  Eigen::Quaterniond R_level_odom = Eigen::Quaterniond::Identity();
  int segment = -1;
  Stamp begin = 0;
  fits.of_segment.resize(drive.in_enu.size());
  for (const DriveGnss& gnss : drive.gnss) {
    const DriveNode& node = node_of(drive, gnss);
    if (node.segment != segment || node.stamp - begin > kWindow) {
      fits.common.begin_window();
      if (segment >= 0) fits.of_segment[static_cast<std::size_t>(segment)].begin_window();
      R_level_odom = R_map_odom(node);
      segment = node.segment;
      begin = node.stamp;
    }
    const TrackedFix fix = tracked_fix(drive, gnss, R_level_odom);
    fits.common.add(fix);
    fits.of_segment[static_cast<std::size_t>(segment)].add(fix);
  }
  fits.common.begin_window();
  for (AntennaFit& fit : fits.of_segment) fit.begin_window();
  return fits;
}

/// What is not certain yet is not corrected, but allowed for.
GnssDelay delay_of(const AntennaFit::Result& result) {
  if (!result.delay_is_known()) {
    return {0.0, std::min(GnssDelay{}.sigma, std::hypot(result.delay, result.delay_sigma))};
  }
  const double sigma = std::max(kLeastSigma, result.delay_sigma);
  if (!result.is_late()) return {0.0, sigma};
  return {result.delay, sigma, result.arm_error};
}

}  // namespace

void find_gnss_delays(DriveGraph& drive, const BackEndConfig& config) {
  if (!config.estimate_gnss_time_offset || drive.gnss.empty()) return;
  const DelayFits fits = fits_of(drive);
  for (std::size_t i = 0; i < fits.of_segment.size(); ++i) {
    const AntennaFit::Result own = fits.of_segment[i].result();
    drive.gnss_delays[i] = delay_of(own.delay_is_known() ? own : fits.common.result());
  }
}

Eigen::Vector3d antenna_velocity(const DriveGraph& drive, const DriveGnss& gnss) {
  return antenna_velocity(motion_at(drive, gnss.node), gnss.position.p_base_antenna);
}

GnssPosition timed_position(const DriveGraph& drive, const DriveGnss& gnss) {
  const DriveNode& node = node_of(drive, gnss);
  const auto segment = static_cast<std::size_t>(node.segment);
  const GnssDelay& delay = drive.gnss_delays[segment];
  const Motion motion = motion_at(drive, gnss.node);
  GnssPosition position = gnss.position;
  position.p_base_antenna.head<2>() += delay.arm_error;
  position.p_base_antenna = arm_before(motion, position.p_base_antenna, delay.seconds);
  const Eigen::Vector3d velocity = antenna_velocity(motion, gnss.position.p_base_antenna);
  const Eigen::Vector2d off = delay.sigma * (node.T_map_base.rotation * velocity).head<2>();
  position.covariance.topLeftCorner<2, 2>() +=
      drive.in_enu[segment] ? Eigen::Matrix2d(off * off.transpose())
                            : Eigen::Matrix2d(off.squaredNorm() * Eigen::Matrix2d::Identity());
  return position;
}

}  // namespace lidar_mapping::back_end
