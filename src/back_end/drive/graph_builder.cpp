// SPDX-License-Identifier: BSD-3-Clause
#include "drive/graph_builder.hpp"

#include <cmath>
#include <string>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/sorted_values.hpp"

#include "gnss/gnss_weights.hpp"
#include "weights/edge_covariance.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Inserts a value into a list that is ordered by node. Returns false if the node has a value
/// already.
template <typename Value>
bool insert_by_node(const Value& value, std::vector<Value>& list) {
  const auto after = first_from(value.node, list);
  if (after != list.end() && after->node == value.node) return false;
  list.insert(after, value);
  return true;
}

bool is_usable(const GnssPosition& position, const BackEndConfig& config) {
  const Eigen::Matrix2d covariance = position.covariance.topLeftCorner<2, 2>();
  if (!position.p_enu_antenna.head<2>().allFinite() || !position.p_base_antenna.allFinite()) {
    return false;
  }
  if (!covariance.allFinite() || covariance(0, 0) <= 0.0 || covariance.determinant() <= 0.0) {
    return false;
  }
  return horizontal_stddev(position, config) <= config.gnss_max_stddev_m;
}

void check_key_frame(const KeyFrame& key_frame, const DriveGraph& drive) {
  if (!is_finite(key_frame.T_odom_base)) {
    throw InputError("key frame " + std::to_string(key_frame.index) +
                     " has a pose that is not finite; the front end must not send it");
  }
  if (drive.nodes.empty() || key_frame.index > drive.nodes.back().index) return;
  throw InputError("key frame " + std::to_string(key_frame.index) + " follows key frame " +
                   std::to_string(drive.nodes.back().index) + "; indices must increase over a run");
}

std::optional<int> position_of(KeyFrameIndex index, const DriveGraph& drive) {
  const auto found = find_index(drive.nodes, index);
  if (found == drive.nodes.end()) return std::nullopt;
  return static_cast<int>(found - drive.nodes.begin());
}

}  // namespace

std::optional<DriveLoop> placed(const Loop& loop, const DriveGraph& drive) {
  const std::optional<int> from = position_of(loop.from, drive);
  const std::optional<int> to = position_of(loop.to, drive);
  if (!from || !to || *from == *to) return std::nullopt;
  if (!is_finite(loop.T_from_to) || !is_valid_covariance(loop.covariance)) return std::nullopt;
  return DriveLoop{loop, *from, *to};
}

template <typename Value>
void GraphBuilder::attach_or_store(const Value& value, PendingMeasurements<Value>& pending,
                                   DriveGraph& drive) {
  const auto found = at_stamp_.find(value.stamp);
  if (found == at_stamp_.end()) {
    pending.add(value.stamp, value);
  } else {
    attach(value, found->second, drive);
  }
}

template <typename Value>
void GraphBuilder::attach_pending(Stamp stamp, PendingMeasurements<Value>& pending,
                                  DriveGraph& drive) {
  if (const auto value = pending.extract(stamp)) attach(*value, at_stamp_.at(stamp), drive);
}

/// Positions of other scans are no part of the graph, and do not count as refused either.
void GraphBuilder::attach(const GnssPosition& position, int node, DriveGraph& drive) {
  if (!is_usable(position, config_)) {
    ++drive.unusable_gnss;
    return;
  }
  if (insert_by_node(DriveGnss{position, node}, drive.gnss)) ++new_data_.gnss;
}
void GraphBuilder::attach(const ImuSample& sample, int node, DriveGraph& drive) {
  insert_by_node(DriveImu{sample, node}, drive.imu);
}
void GraphBuilder::attach(const Floor& floor, int node, DriveGraph& drive) {
  insert_by_node(DriveFloor{floor, node}, drive.floors);
}

void GraphBuilder::add_step(const KeyFrame& key_frame, const DriveNode& previous, DriveNode& node) {
  const Pose motion = previous.T_odom_base.inverse() * node.T_odom_base;
  distance_in_segment_ += motion.translation.norm();
  node.connected = true;
  node.doubtful = key_frame.doubtful;
  node.step_covariance = step_covariance(key_frame.motion_covariance, motion, distance_in_segment_,
                                         key_frame.degenerate_directions, config_);
}

void GraphBuilder::begin_segment(DriveGraph& drive) {
  distance_in_segment_ = 0.0;
  drive.segment_starts.push_back(static_cast<int>(drive.nodes.size()));
  drive.in_enu.push_back(false);
  GnssDelay delay;
  if (!config_.estimate_gnss_time_offset) delay.sigma = 0.0;
  drive.gnss_delays.push_back(delay);
}

void GraphBuilder::add_key_frame(const KeyFrame& key_frame, DriveGraph& drive) {
  check_key_frame(key_frame, drive);
  DriveNode node;
  node.index = key_frame.index;
  node.stamp = key_frame.stamp;
  node.T_odom_base = key_frame.T_odom_base;
  const bool is_first = drive.nodes.empty();
  node.T_map_base = is_first ? key_frame.T_odom_base : drive.T_map_odom() * key_frame.T_odom_base;
  if (is_first) drive.T_map_first = node.T_map_base;
  if (!is_first && key_frame.segment == newest_segment_) {
    add_step(key_frame, drive.nodes.back(), node);
  } else {
    begin_segment(drive);
  }
  node.segment = static_cast<int>(drive.segment_starts.size()) - 1;
  newest_segment_ = key_frame.segment;
  at_stamp_[node.stamp] = static_cast<int>(drive.nodes.size());
  drive.nodes.push_back(node);
  attach_pending(node.stamp, pending_gnss_, drive);
  attach_pending(node.stamp, pending_imu_, drive);
  attach_pending(node.stamp, pending_floors_, drive);
  ++new_data_.key_frames;
}

bool GraphBuilder::add_loop(const Loop& loop, DriveGraph& drive) {
  std::optional<DriveLoop> added = placed(loop, drive);
  if (!added) return false;
  added->evaluated = !config_.use_loop_close || loop.decision == LoopDecision::kRefuse;
  drive.loops.push_back(*added);
  ++new_data_.loops;
  return true;
}

void GraphBuilder::add_gnss(const GnssPosition& position, DriveGraph& drive) {
  attach_or_store(position, pending_gnss_, drive);
}

void GraphBuilder::add_imu(const ImuSample& sample, DriveGraph& drive) {
  const bool known = sample.linear_acceleration.allFinite() &&
                     (!sample.orientation || sample.orientation->coeffs().allFinite());
  if (known) attach_or_store(sample, pending_imu_, drive);
}

void GraphBuilder::add_floor(const Floor& floor, DriveGraph& drive) {
  const bool known =
      floor.normal.allFinite() && std::isfinite(floor.offset) && floor.covariance.allFinite();
  if (floor.found && known) attach_or_store(floor, pending_floors_, drive);
}

}  // namespace lidar_mapping::back_end
