// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>

namespace lidar_mapping::tools {

/// Memory of this process in bytes: now, and at most so far.
std::size_t resident_bytes();
std::size_t peak_bytes();

/// Clouds that one thread makes and another lets go leave holes in the heap, which would add up
/// over hours. While this object lives they go back to the system as soon as the process has grown
/// by some tens of megabytes, and threads share two heaps instead of having many. To be made before
/// other threads are.
class ReturnedMemory {
 public:
  ReturnedMemory();
  ~ReturnedMemory();
  ReturnedMemory(const ReturnedMemory&) = delete;
  ReturnedMemory& operator=(const ReturnedMemory&) = delete;

 private:
  void watch();

  std::mutex mutex_;
  std::condition_variable ending_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace lidar_mapping::tools
