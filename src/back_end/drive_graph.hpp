// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::back_end {

/// A key frame as the graph keeps it.
struct DriveNode {
  KeyFrameIndex index = 0;
  int segment = 0;         ///< in order of appearance
  bool connected = false;  ///< odometry joins it to the node before
  bool fixed = false;      ///< at the border of a window
  /// A step of the motion to it may be wrong: no reason to refuse a loop.
  bool doubtful = false;
  Stamp stamp = 0;
  Pose T_odom_base;
  Pose T_map_base;
  Covariance6 step_covariance = Covariance6::Identity();  ///< of the motion to it, but for drift
};

struct DriveLoop {
  Loop loop;
  int from = 0;  ///< position in DriveGraph::nodes
  int to = 0;
  bool used = false;
  bool evaluated = false;  ///< some solution, or a person, has judged it
};

struct DriveGnss {
  GnssPosition position;
  int node = 0;
  bool horizontal_used = false;
  bool altitude_used = false;
  bool evaluated = false;
};

struct DriveImu {
  ImuSample sample;  ///< in base_link
  int node = 0;
};

struct DriveFloor {
  Floor floor;
  int node = 0;
};

/// By how much the stamps of GNSS are late and how well that is known: at first not at all.
struct GnssDelay {
  double seconds = 0.0;
  double sigma = 0.05;                                  ///< s
  Eigen::Vector2d arm_error = Eigen::Vector2d::Zero();  ///< m, in base_link, found with it

  bool is_corrected() const { return seconds != 0.0; }
};

/// How odometry errs, as far as positions show it.
struct OdometryErrors {
  double scale_error = 0.0;  ///< share by which its way has to be lengthened
  /// Of the configured drift's standard deviations: translation and rotation in base_link.
  Vector6d drift_fraction = Vector6d::Ones();
};

/// All that the back end knows of a drive, as values.
struct DriveGraph {
  std::vector<DriveNode> nodes;
  std::vector<DriveLoop> loops;
  std::vector<DriveGnss> gnss;  ///< by node, as are the next two
  std::vector<DriveImu> imu;
  std::vector<DriveFloor> floors;
  std::size_t unusable_gnss = 0;       ///< positions without a meaning or too uncertain
  Pose T_map_first;                    ///< where the prior holds the first node
  std::vector<bool> in_enu;            ///< per segment: lies in East-North-Up
  std::vector<GnssDelay> gnss_delays;  ///< per segment
  OdometryErrors odometry_errors;
  /// Of the tilt by the IMU's orientation, deg, as the drive shows it (tilt_scatter.hpp); none: as
  /// configured.
  std::optional<double> tilt_stddev_deg;
  std::vector<int> segment_starts;  ///< position of each segment's first node; none in a window

  /// The correction between odometry and map at the newest node.
  Pose T_map_odom() const {
    if (nodes.empty()) return Pose::Identity();
    return nodes.back().T_map_base * nodes.back().T_odom_base.inverse();
  }
  int segment_of(int node) const { return nodes[static_cast<std::size_t>(node)].segment; }
};

/// For each segment the least segment that loops tie it to. Loops that no solution has judged yet
/// count if `with_unweighed_loops`.
std::vector<int> connected_segments(const DriveGraph& drive, bool with_unevaluated_loops);

/// Odometry from the node before to this one, which it joins, and its covariance: what the drive
/// shows of its errors is taken into account.
Pose motion_to(const DriveGraph& drive, std::size_t node);
Covariance6 motion_covariance_to(const DriveGraph& drive, std::size_t node,
                                 const BackEndConfig& config);

/// How many loops and positions the graph believes and refuses.
struct UsageCounts {
  std::size_t loops_used = 0;
  std::size_t loops_refused = 0;
  std::size_t gnss_used = 0;
  std::size_t gnss_refused = 0;
};
UsageCounts count_usage(const DriveGraph& drive);

/// The rotation that makes the map's z axis vertical, as the IMU saw it from all nodes of the
/// marked segments; the identity where no IMU is in use.
Eigen::Quaterniond gravity_alignment(const DriveGraph& drive, const std::vector<bool>& segments,
                                     const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
