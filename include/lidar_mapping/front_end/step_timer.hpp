// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace lidar_mapping::front_end {

/// Measures the computing time of the steps of a scan. It is used for reports only: no result
/// depends on it.
class StepTimer {
 public:
  /// Starts a step and ends the previous one.
  void start(const char* step) {
    stop();
    step_ = step;
    begin_ = Clock::now();
  }
  /// Ends the current step, if there is one.
  void stop() {
    if (step_ == nullptr) return;
    steps_.emplace_back(step_, std::chrono::duration<double>(Clock::now() - begin_).count());
    step_ = nullptr;
  }
  /// Ends the current step and returns all steps since the last call, in order: name and s.
  std::vector<std::pair<std::string, double>> take() {
    stop();
    return std::exchange(steps_, {});
  }

 private:
  using Clock = std::chrono::steady_clock;
  const char* step_ = nullptr;
  Clock::time_point begin_;
  std::vector<std::pair<std::string, double>> steps_;
};

}  // namespace lidar_mapping::front_end
