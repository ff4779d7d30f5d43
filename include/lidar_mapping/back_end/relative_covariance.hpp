// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/pose_graph/block_cholesky.hpp"

namespace lidar_mapping::back_end {

/// Covariances of key frames relative to one key frame, which is taken as known exactly. The
/// constructor takes about as long as one step of the solver, each query much less. A key frame
/// that no constraint connects with the known one has a standard deviation of one kilometre.
class RelativeCovariance {
 public:
  /// Constraints that are taken into account.
  enum class Given {
    kOdometry,  ///< odometry alone
    kAll        ///< all constraints that the graph uses: odometry, loops, GNSS, IMU, floors
  };

  /// Factorises the information matrix with key frame `from` known.
  RelativeCovariance(const OptimizationProblem& problem, KeyFrameIndex from, Given given);

  /// Covariance of key frame `to` in its own axes, m and rad. Empty for an unknown key frame, or if
  /// the graph cannot be solved.
  std::optional<Covariance6> of(KeyFrameIndex to) const;

 private:
  std::optional<int> row_of(KeyFrameIndex index) const;

  std::vector<KeyFrameIndex> key_frames_;  ///< of the rows
  int states_ = 0;
  std::unique_ptr<pose_graph::BlockCholesky<6>> system_;
  bool is_solvable_ = false;
};

}  // namespace lidar_mapping::back_end
