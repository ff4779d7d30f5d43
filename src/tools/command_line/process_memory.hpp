// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>

namespace lidar_mapping::tools {

/// Memory of this process in bytes: present and peak.
std::size_t resident_bytes();
std::size_t peak_bytes();
/// The peak in units of 2^20 bytes.
double peak_mebibytes();

/// Returns freed memory to the system. Clouds that are allocated by one thread and freed by another
/// leave gaps in the heap, which would accumulate over hours. During the lifetime of this object
/// they are returned as soon as the process has grown by some tens of megabytes, and threads share
/// two heaps instead of having many. It has to be created before other threads.
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
