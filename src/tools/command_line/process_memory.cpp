// SPDX-License-Identifier: BSD-3-Clause
#include "command_line/process_memory.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

namespace lidar_mapping::tools {

namespace {

// Number of heaps of malloc (M_ARENA_MAX), which by default has eight for each core, each with
// freed pages of its own. Chosen: with only one, threads would wait for each other.
constexpr int kHeaps = 2;
// Bytes; larger blocks are returned to the system when freed. Chosen: above the grids and images of
// some megabytes that each key frame needs; if the system had to provide them each time, this would
// take a quarter of the processor time of build_map.
constexpr int kOwnMapping = 8'000'000;
// Bytes; growth of the process at which memory is returned. Measured: with 16 MB a quarter of the
// processor time of build_map goes to page faults.
constexpr std::size_t kStep = 64'000'000;
constexpr std::chrono::milliseconds kPeriod{100};

}  // namespace

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t whole = 0, resident = 0;
  file >> whole >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

std::size_t peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

double peak_mebibytes() { return static_cast<double>(peak_bytes()) / (1024.0 * 1024.0); }

ReturnedMemory::ReturnedMemory() {
  mallopt(M_ARENA_MAX, kHeaps);
  mallopt(M_MMAP_THRESHOLD, kOwnMapping);
  mallopt(M_TRIM_THRESHOLD, kStep);
  thread_ = std::thread([this] { watch(); });
}

ReturnedMemory::~ReturnedMemory() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  ending_.notify_one();
  thread_.join();
}

void ReturnedMemory::watch() {
  std::size_t least = resident_bytes();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ending_.wait_for(lock, kPeriod, [this] { return ended_; })) {
    const std::size_t resident = resident_bytes();
    least = std::min(least, resident);
    if (resident < least + kStep) continue;
    malloc_trim(0);
    least = resident_bytes();
  }
}

}  // namespace lidar_mapping::tools
