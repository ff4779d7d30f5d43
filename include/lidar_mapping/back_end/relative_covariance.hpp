// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "lidar_mapping/back_end/back_end.hpp"

namespace lidar_mapping::back_end {

/// How well the graph knows key frames if one of them were known exactly: by odometry alone, or by
/// all that it believes (loops, GNSS, floors). Being made takes about as long as one step of the
/// solver, each question much less. What no constraint ties to that key frame has a standard
/// deviation of a kilometre.
class RelativeCovariance {
 public:
  enum class Given { kOdometry, kAll };

  RelativeCovariance(const OptimizationProblem& problem, KeyFrameIndex from, Given given);
  ~RelativeCovariance();

  /// In the axes of `to`. None for an unknown key frame.
  std::optional<Covariance6> of(KeyFrameIndex to) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::back_end
