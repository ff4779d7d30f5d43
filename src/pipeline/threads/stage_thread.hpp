// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "lidar_mapping/common/thread_time.hpp"

namespace lidar_mapping::pipeline {

/// One stage of a pipeline: a thread behind a queue of bounded length. A producer that is too fast
/// waits, so that nothing is lost and memory is bounded. The work of a stage depends on the order
/// of its items alone, never on the progress of other stages.
template <typename Item>
class StageThread {
 public:
  using Handle = std::function<void(Item&&)>;

  /// Without a thread of its own, push() does the work before it returns.
  StageThread(std::size_t capacity, bool own_thread, Handle handle)
      : capacity_(capacity), handle_(std::move(handle)) {
    if (own_thread) thread_ = std::thread([this] { run(); });
  }
  ~StageThread() {
    abandon();
    if (thread_.joinable()) thread_.join();
  }
  StageThread(const StageThread&) = delete;
  StageThread& operator=(const StageThread&) = delete;

  /// Appends an item; waits while the queue is full. Throws what the stage threw for an earlier
  /// item.
  void push(Item item) {
    if (!thread_.joinable()) return handle(std::move(item));
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return waiting_.size() < capacity_ || error_; });
    rethrow();
    waiting_.push_back(std::move(item));
    changed_.notify_all();
  }

  /// Returns when all items are processed. Throws what the stage threw.
  void finish() {
    if (thread_.joinable()) {
      close();
      thread_.join();
    }
    rethrow();
  }

  /// Processor time of the stage so far, s.
  double seconds() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return seconds_;
  }

 private:
  void handle(Item&& item) {
    const ThreadTime time;
    handle_(std::move(item));
    const std::lock_guard<std::mutex> lock(mutex_);
    seconds_ += time.seconds();
  }

  void run() {
    for (;;) {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [&] { return !waiting_.empty() || closed_; });
      if (waiting_.empty()) return;
      Item item = std::move(waiting_.front());
      waiting_.pop_front();
      changed_.notify_all();
      lock.unlock();
      try {
        handle(std::move(item));
      } catch (...) {
        return fail(std::current_exception());
      }
    }
  }

  void fail(std::exception_ptr error) {
    const std::lock_guard<std::mutex> lock(mutex_);
    error_ = std::move(error);
    waiting_.clear();
    changed_.notify_all();
  }
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  void abandon() {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    waiting_.clear();
    changed_.notify_all();
  }
  void rethrow() {
    if (error_) std::rethrow_exception(error_);
  }

  const std::size_t capacity_;
  const Handle handle_;
  mutable std::mutex mutex_;  ///< Guards the members below.
  std::condition_variable changed_;
  std::deque<Item> waiting_;
  std::exception_ptr error_;
  bool closed_ = false;
  double seconds_ = 0.0;
  std::thread thread_;
};

}  // namespace lidar_mapping::pipeline
