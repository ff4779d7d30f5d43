// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace lidar_mapping {

/// An order between threads that the thread sanitizer cannot see, because the library that keeps it
/// is compiled without it: what a thread did before release() has happened before what another one
/// does after acquire() of the same object. Orders nothing by itself, and costs nothing elsewhere.
class HappensBefore {
 public:
#if defined(__SANITIZE_THREAD__)
  void release() { __tsan_release(this); }
  void acquire() { __tsan_acquire(this); }
#else
  void release() {}
  void acquire() {}
#endif
};

}  // namespace lidar_mapping
