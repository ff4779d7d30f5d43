// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <mutex>

#include <ros/publisher.h>

#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/scan_numbers.hpp"
#include "lidar_mapping/ros/warning_limiter.hpp"

namespace lidar_mapping::ros_border {

/// Counts scans that preprocessing_node has never processed, so that a map with gaps is recognised
/// as such: those that are missing by the numbers of the messages, and those that were dropped from
/// the queue. Publishes their number as scans_lost (latched).
class ScanLossCounter {
 public:
  /// Advertises the topic. `context` outlives this object.
  explicit ScanLossCounter(NodeContext& context);

  /// Adds the number (header.seq) of a received scan. Any thread may call it.
  void add(std::uint32_t number);
  /// Logs and publishes new losses. One thread calls it.
  void report();

 private:
  ScanNumbers numbers();
  void log_missing(std::size_t missing, std::size_t before_first);

  NodeContext& context_;
  std::mutex mutex_;
  ScanNumbers numbers_;               ///< of the received scans; guarded by mutex_
  std::size_t logged_missing_ = 0;    ///< missing scans that were logged
  std::size_t published_losses_ = 0;  ///< newest published value
  WarningLimiter limiter_;
  ros::Publisher publisher_;
};

}  // namespace lidar_mapping::ros_border
