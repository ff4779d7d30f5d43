// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/warning_limiter.hpp"
#include "lidar_mapping/ros/worker.hpp"

namespace lidar_mapping::ros_border {

/// A node's status on /diagnostics, once a second: state, rates, lag of the data, waiting, dropped
/// and refused messages. New losses are also reported in the log, at most once in 5 s, with their
/// number. Any thread may call it.
class Diagnostics {
 public:
  /// Levels of diagnostic_msgs/DiagnosticStatus.
  enum class Level : unsigned char {
    kOk = diagnostic_msgs::DiagnosticStatus::OK,         ///< all is well
    kWarning = diagnostic_msgs::DiagnosticStatus::WARN,  ///< something is lost or left out
    kError = diagnostic_msgs::DiagnosticStatus::ERROR    ///< the node does not do its work
  };

  /// Starts the reports. `worker` is the one whose channels are reported, and outlives this object.
  Diagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
              const Worker& worker);

  /// What the node is doing; stays until the next call.
  void set_state(Level level, const std::string& text);
  /// A figure that belongs to this node.
  void set(const std::string& key, const std::string& value);
  /// The same for a number, with the digits of std::to_string().
  template <typename Number, typename = std::enable_if_t<std::is_arithmetic_v<Number>>>
  void set(const std::string& key, Number value) {
    set(key, std::to_string(value));
  }
  /// A datum with this stamp has arrived: counts for rate and lag.
  void count_input(Stamp stamp);
  /// A result with this stamp has left: counts for rate and lag.
  void count_output(Stamp stamp);

 private:
  struct Flow {
    std::size_t count = 0;  ///< since the last report
    std::optional<Stamp> newest;
  };

  void tick();
  void fill(diagnostic_updater::DiagnosticStatusWrapper& status);
  void report_losses(const std::vector<Worker::ChannelStatistics>& channels);

  const Worker& worker_;
  mutable std::mutex mutex_;
  Level level_ = Level::kOk;
  std::string state_ = "waiting for data";
  std::map<std::string, std::string> values_;
  Flow input_;
  Flow output_;
  std::map<std::string, std::size_t> reported_losses_;
  ros::WallTime reported_at_;
  WarningLimiter limiter_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace lidar_mapping::ros_border
