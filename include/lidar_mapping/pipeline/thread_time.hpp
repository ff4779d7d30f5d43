// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::pipeline {

/// Processor time that this thread spends while the object lives, without that of such objects
/// which live and die in the meantime: where stages call each other each counts its own work.
class ThreadTime {
 public:
  ThreadTime();
  ~ThreadTime();
  ThreadTime(const ThreadTime&) = delete;
  ThreadTime& operator=(const ThreadTime&) = delete;

  double seconds() const;

 private:
  double begin_;
  double outer_;  ///< spent in objects that ended, as it stood when this one began
};

}  // namespace lidar_mapping::pipeline
