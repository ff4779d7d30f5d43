// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/thread_time.hpp"

#include <ctime>
#include <utility>

namespace lidar_mapping {

namespace {

/// Time of objects that have ended within the innermost one that is alive, s.
thread_local double inner_seconds = 0.0;

double now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

ThreadTime::ThreadTime() : begin_(now()), outer_(std::exchange(inner_seconds, 0.0)) {}

ThreadTime::~ThreadTime() { inner_seconds = outer_ + (now() - begin_); }

double ThreadTime::seconds() const { return now() - begin_ - inner_seconds; }

}  // namespace lidar_mapping
