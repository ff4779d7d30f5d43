// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/diagnostics.hpp"

#include <array>

#include <ros/console.h>
#include <unistd.h>

namespace lidar_mapping::ros_border {

namespace {

const ros::WallDuration kReportInterval(1.0);

/// Name of the computer, as hardware ID: a node has no other hardware.
std::string computer() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown computer";
}

std::size_t losses(const Worker::ChannelStatistics& channel) {
  return channel.dropped + channel.lost;
}

}  // namespace

Diagnostics::Diagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                         const Worker& worker)
    : worker_(worker), reported_at_(ros::WallTime::now()), updater_(node, private_node) {
  updater_.setHardwareID(computer());
  updater_.add("state", [this](diagnostic_updater::DiagnosticStatusWrapper& s) { fill(s); });
  timer_ = node.createWallTimer(kReportInterval, [this](const ros::WallTimerEvent&) { tick(); });
}

void Diagnostics::set_state(Level level, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  level_ = level;
  state_ = text;
}

void Diagnostics::set(const std::string& key, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  values_[key] = value;
}

void Diagnostics::count_input(Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++input_.count;
  input_.newest = stamp;
}

void Diagnostics::count_output(Stamp stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++output_.count;
  output_.newest = stamp;
}

void Diagnostics::tick() {
  report_losses(worker_.statistics());
  // Not update(): its interval is measured with simulated time, which may stand still.
  updater_.force_update();
}

void Diagnostics::report_losses(const std::vector<Worker::ChannelStatistics>& channels) {
  for (const auto& channel : channels) {
    std::size_t& reported = reported_losses_[channel.name];
    if (losses(channel) == reported || !limiter_.due(channel.name)) continue;
    ROS_WARN_STREAM(channel.name << ": " << losses(channel) - reported << " messages lost ("
                                 << losses(channel) << " since the start): the node does not keep "
                                 << "up; play slower (rosbag play -r) or raise ~queue_size");
    reported = losses(channel);
  }
}

void Diagnostics::fill(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::vector<Worker::ChannelStatistics> channels = worker_.statistics();
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = std::max(1e-3, (now - reported_at_).toSec());
  reported_at_ = now;
  status.summary(static_cast<unsigned char>(level_), state_);
  status.addf("input rate (Hz)", "%.1f", static_cast<double>(input_.count) / seconds);
  status.addf("output rate (Hz)", "%.1f", static_cast<double>(output_.count) / seconds);
  input_.count = output_.count = 0;
  if (input_.newest && output_.newest) {
    status.addf("lag (s)", "%.3f", to_seconds(*input_.newest - *output_.newest));
  }
  for (const auto& channel : channels) {
    status.addf("queue " + channel.name,
                "%zu waiting, %zu handled, %zu dropped, %zu lost, %zu refused", channel.waiting,
                channel.handled, channel.dropped, channel.lost, channel.refused);
    if (losses(channel) > 0) {
      status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, channel.name + " lost messages");
    }
  }
  for (const auto& [key, value] : values_) status.add(key, value);
}

}  // namespace lidar_mapping::ros_border
