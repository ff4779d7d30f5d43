// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/worker.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace lidar_mapping::ros_border {

Worker::Worker(std::function<void(const std::string&, const std::string&)> on_error)
    : on_error_(std::move(on_error)), thread_([this] { run(); }) {}

Worker::ChannelId Worker::add_channel(const std::string& name, std::size_t capacity) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Channel channel;
  channel.capacity = std::max<std::size_t>(1, capacity);
  channel.statistics.name = name;
  channels_.push_back(std::move(channel));
  return channels_.size() - 1;
}

void Worker::post(ChannelId id, Task task) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Channel& channel = channels_.at(id);
    if (stopping_) {
      ++channel.statistics.dropped;
      return;
    }
    if (channel.tasks.size() == channel.capacity) {
      channel.tasks.pop_front();
      ++channel.statistics.dropped;
    }
    channel.tasks.push_back({next_number_++, std::move(task)});
  }
  wake_.notify_one();
}

void Worker::add_lost(ChannelId id, std::size_t count) {
  const std::lock_guard<std::mutex> lock(mutex_);
  channels_.at(id).statistics.lost += count;
}

void Worker::set_idle_task(std::chrono::milliseconds after, Task task) {
  const std::lock_guard<std::mutex> lock(mutex_);
  idle_after_ = after;
  idle_task_ = std::move(task);
}

void Worker::drain_on_stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  drains_on_stop_ = true;
}

void Worker::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
    if (!drains_on_stop_) discard_all();
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

std::vector<Worker::ChannelStatistics> Worker::statistics() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<ChannelStatistics> result;
  for (const Channel& channel : channels_) {
    result.push_back(channel.statistics);
    result.back().waiting = channel.tasks.size();
  }
  return result;
}

std::size_t Worker::losses(const std::string& channel) const {
  std::size_t count = 0;
  for (const ChannelStatistics& each : statistics()) {
    if (each.name == channel) count += each.dropped + each.lost;
  }
  return count;
}

void Worker::discard_all() {
  for (Channel& channel : channels_) {
    channel.statistics.dropped += channel.tasks.size();
    channel.tasks.clear();
  }
}

/// The channel with the oldest waiting task.
std::optional<Worker::ChannelId> Worker::next_channel() const {
  std::optional<ChannelId> next;
  for (ChannelId id = 0; id < channels_.size(); ++id) {
    if (channels_[id].tasks.empty()) continue;
    if (!next || channels_[id].tasks.front().number < channels_[*next].tasks.front().number) {
      next = id;
    }
  }
  return next;
}

void Worker::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  bool worked = false;
  while (true) {
    if (const auto id = next_channel()) {
      run_task(*id, lock);
      worked = true;
    } else if (stopping_) {
      return;
    } else if (worked && idle_task_) {
      worked = !wait_for_idle(lock);
    } else {
      wake_.wait(lock);
    }
  }
}

void Worker::run_task(ChannelId id, std::unique_lock<std::mutex>& lock) {
  const Task task = std::move(channels_[id].tasks.front().task);
  channels_[id].tasks.pop_front();
  const std::string name = channels_[id].statistics.name;
  lock.unlock();
  const bool good = guarded(name, task);
  lock.lock();
  ChannelStatistics& statistics = channels_[id].statistics;
  ++(good ? statistics.handled : statistics.refused);
}

/// True if the time passed without work and the idle task ran.
bool Worker::wait_for_idle(std::unique_lock<std::mutex>& lock) {
  const auto end = std::chrono::steady_clock::now() + idle_after_;
  if (wake_.wait_until(lock, end, [this] { return stopping_ || next_channel(); })) return false;
  const Task task = idle_task_;
  lock.unlock();
  guarded("idle", task);
  lock.lock();
  return true;
}

bool Worker::guarded(const std::string& channel, const Task& task) {
  try {
    task();
    return true;
  } catch (const std::exception& error) {
    on_error_(channel, error.what());
    return false;
  }
}

}  // namespace lidar_mapping::ros_border
