// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/scan_loss_counter.hpp"

#include <utility>

#include <std_msgs/UInt32.h>

namespace lidar_mapping::ros_border {

ScanLossCounter::ScanLossCounter(NodeContext& context)
    : context_(context),
      publisher_(context.node.advertise<std_msgs::UInt32>("scans_lost", 1, true)) {}

void ScanLossCounter::add(std::uint32_t number) {
  const std::lock_guard<std::mutex> lock(mutex_);
  numbers_.add(number);
}

ScanNumbers ScanLossCounter::numbers() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return numbers_;
}

void ScanLossCounter::report() {
  const ScanNumbers received = numbers();
  // On a vehicle the driver has published scans before this node started, which is no loss; of a
  // recording all scans should arrive.
  const std::size_t missing = ros::Time::isSimTime() ? received.missing() : received.between();
  context_.diagnostics.set("scans missing by their numbers", missing);
  if (missing != logged_missing_ && limiter_.due("missing")) {
    log_missing(missing, missing - received.between());
  }
  const std::size_t lost = missing + context_.worker.losses("points");
  if (std::exchange(published_losses_, lost) == lost) return;
  std_msgs::UInt32 message;
  message.data = static_cast<std::uint32_t>(lost);
  publisher_.publish(message);
}

void ScanLossCounter::log_missing(std::size_t missing, std::size_t before_first) {
  logged_missing_ = missing;
  ROS_WARN_STREAM("scans that never came: "
                  << missing << " (by their numbers), " << before_first
                  << " of them before the first one; play a bag with -d 3, which gives the nodes "
                     "the time to connect, and slower (-r 0.5) where some are missing later");
}

}  // namespace lidar_mapping::ros_border
