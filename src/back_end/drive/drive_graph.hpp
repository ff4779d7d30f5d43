// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/usage_counts.hpp"

namespace lidar_mapping::back_end {

/// A key frame in the graph.
struct DriveNode {
  KeyFrameIndex index = 0;
  int segment = 0;         ///< number of the segment, in the order of their first key frames
  bool connected = false;  ///< odometry connects it to the previous node
  bool fixed = false;      ///< constant, at the border of a window
  /// A step of the motion to it may be wrong, so that it is no evidence against a loop.
  bool doubtful = false;
  Stamp stamp = 0;
  Pose T_odom_base;
  Pose T_map_base;
  Covariance6 step_covariance = Covariance6::Identity();  ///< of the motion to it, without drift
};

struct DriveLoop {
  Loop loop;
  int from = 0;  ///< position in DriveGraph::nodes
  int to = 0;
  bool used = false;
  bool evaluated = false;  ///< a solution, a person or use_loop_close has decided about it
};

struct DriveGnss {
  GnssPosition position;
  int node = 0;
  bool horizontal_used = false;
  bool altitude_used = false;
  bool evaluated = false;
};

struct DriveImu {
  ImuSample sample;  ///< in the axes of base_link
  int node = 0;
};

struct DriveFloor {
  Floor floor;
  int node = 0;
};

/// Delay of the stamps of GNSS and its uncertainty. At the beginning the delay is not known.
struct GnssDelay {
  double seconds = 0.0;
  double sigma = 0.05;  ///< standard deviation of the delay, s
  /// Correction of the lever arm that was estimated with the delay, m, in base_link.
  Eigen::Vector2d arm_error = Eigen::Vector2d::Zero();

  bool is_corrected() const { return seconds != 0.0; }
};

/// Errors of the odometry, as far as positions show them.
struct OdometryErrors {
  /// Relative scale error: the distance travelled is too short by this fraction.
  double scale_error = 0.0;
  /// Fraction of the configured standard deviations of the drift: translation and rotation in the
  /// axes of base_link.
  Vector6d drift_fraction = Vector6d::Ones();
};

/// What was measured at single nodes: lists that are ordered by node. extract_window() takes every
/// one of them apart, and does not compile if one is missing there.
struct NodeMeasurements {
  std::vector<DriveGnss> gnss;
  std::vector<DriveImu> imu;
  std::vector<DriveFloor> floors;
};

/// The first of such values at this node or after it.
template <typename Values>
auto first_from(int node, Values& values) {
  return std::lower_bound(values.begin(), values.end(), node,
                          [](const auto& value, int wanted) { return value.node < wanted; });
}

/// All data of a drive in the back end, as values.
struct DriveGraph : NodeMeasurements {
  std::vector<DriveNode> nodes;
  std::vector<DriveLoop> loops;
  std::size_t unusable_gnss = 0;       ///< number of positions that are not finite or too uncertain
  Pose T_map_first;                    ///< pose of the prior of the first node
  std::vector<bool> in_enu;            ///< per segment: it is aligned to East-North-Up
  std::vector<GnssDelay> gnss_delays;  ///< one per segment
  OdometryErrors odometry_errors;
  /// Standard deviation of the tilt by the IMU's orientation, rad, as estimated from the drive
  /// (tilt_scatter.hpp). Empty: as configured.
  std::optional<double> tilt_stddev;
  /// Position of the first node of each segment; empty in a window.
  std::vector<int> segment_starts;

  /// The correction from odometry to the map at the newest node.
  Pose T_map_odom() const {
    if (nodes.empty()) return Pose::Identity();
    return nodes.back().T_map_base * nodes.back().T_odom_base.inverse();
  }
  int segment_of(int node) const { return nodes[node].segment; }
};

/// For each segment the smallest number of a segment that loops connect it to. Loops that are not
/// evaluated yet count if `with_unevaluated_loops` is true.
std::vector<int> connected_segments(const DriveGraph& drive, bool with_unevaluated_loops);

/// For each group of segments, by its smallest number: whether one of them was aligned to
/// East-North-Up. `connected` is as from connected_segments().
std::vector<bool> groups_in_enu(const DriveGraph& drive, const std::vector<int>& connected);

/// The segments that were aligned to East-North-Up, and those that loops connect with them.
std::vector<bool> segments_in_enu(const DriveGraph& drive);

/// The motion by odometry from the previous node to this one, which must be connected, and its
/// covariance. Both include the estimated errors of the odometry.
Pose motion_to(const DriveGraph& drive, std::size_t node);
Covariance6 motion_covariance_to(const DriveGraph& drive, std::size_t node,
                                 const BackEndConfig& config);

/// Counts what the graph uses of its loops and positions.
UsageCounts count_usage(const DriveGraph& drive);

/// The rotation that makes the map's z axis vertical, from the IMU at all nodes of the selected
/// segments. The identity if no IMU is used.
Eigen::Quaterniond gravity_alignment(const DriveGraph& drive, const std::vector<bool>& segments,
                                     const BackEndConfig& config);

}  // namespace lidar_mapping::back_end
