// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace lidar_mapping::ros_border {

/// The computing thread of a node. Callbacks post tasks and return at once; the thread runs them in
/// the order of their arrival. Every source of tasks has a channel of limited length: when it is
/// full its oldest task is dropped and counted, so that a slow node uses recent data and limited
/// memory. A long channel makes a node lossless, but late.
class Worker {
 public:
  using Task = std::function<void()>;  ///< called once by the thread
  using ChannelId = std::size_t;       ///< number of a channel of this worker

  /// Numbers of tasks of a channel since the start.
  struct ChannelStatistics {
    std::string name;         ///< of the channel
    std::size_t waiting = 0;  ///< now
    std::size_t handled = 0;  ///< done
    std::size_t dropped = 0;  ///< dropped from the full channel, or discarded at the end
    std::size_t lost = 0;     ///< never arrived here; see add_lost()
    std::size_t refused = 0;  ///< ended with an exception
  };

  /// `on_error(channel, what)` is called for tasks that ended with an exception; the thread
  /// continues.
  explicit Worker(std::function<void(const std::string&, const std::string&)> on_error);
  /// Stops.
  ~Worker() { stop(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Adds a channel in which up to `capacity` tasks may wait (at least one).
  ChannelId add_channel(const std::string& name, std::size_t capacity);
  /// Puts a task into a channel. Never blocks. After stop() the task is dropped.
  void post(ChannelId id, Task task);
  /// Counts messages that the transport lost before they could be posted.
  void add_lost(ChannelId id, std::size_t count);
  /// Runs `task` in the thread once after nothing has happened for `after`; again after more work.
  void set_idle_task(std::chrono::milliseconds after, Task task);
  /// From now on stop() does the tasks that wait, instead of dropping them.
  void drain_on_stop();

  /// Ends the thread after the present task, or after all waiting ones. May be called again.
  void stop();
  /// Of all channels, in the order of their making.
  std::vector<ChannelStatistics> statistics() const;
  /// Messages of a channel that were dropped or lost.
  std::size_t losses(const std::string& channel) const;

 private:
  struct WaitingTask {
    std::uint64_t number;  ///< order of arrival over all channels
    Task task;
  };
  struct Channel {
    std::size_t capacity = 1;
    std::deque<WaitingTask> tasks;
    ChannelStatistics statistics;
  };

  void discard_all();
  std::optional<ChannelId> next_channel() const;
  void run();
  void run_task(ChannelId id, std::unique_lock<std::mutex>& lock);
  bool wait_for_idle(std::unique_lock<std::mutex>& lock);
  bool guarded(const std::string& channel, const Task& task);

  std::function<void(const std::string&, const std::string&)> on_error_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Channel> channels_;
  std::uint64_t next_number_ = 0;
  std::chrono::milliseconds idle_after_{0};
  Task idle_task_;
  bool drains_on_stop_ = false;
  bool stopping_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace lidar_mapping::ros_border
