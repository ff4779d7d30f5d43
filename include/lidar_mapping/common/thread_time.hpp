// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

/// Measures the processor time of the calling thread during the lifetime of the object. The time of
/// other such objects that live within this lifetime is excluded, so that stages which call each
/// other each count their own work only.
class ThreadTime {
 public:
  /// Starts measuring.
  ThreadTime();
  /// Ends measuring.
  ~ThreadTime();
  ThreadTime(const ThreadTime&) = delete;
  ThreadTime& operator=(const ThreadTime&) = delete;

  /// Processor time so far, s.
  double seconds() const;

 private:
  double begin_;
  double outer_;  ///< Time of inner objects that had ended when this one began, s.
};

}  // namespace lidar_mapping
