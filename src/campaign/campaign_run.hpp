// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "campaign_case.hpp"
#include "step_checker.hpp"

namespace lidar_mapping::campaign {

/// What the front end made of one drive.
struct CampaignFigures : StepCounts {
  std::size_t scans = 0;
  std::optional<double> drift_percent;  ///< none where the drive is too short
  std::size_t lost = 0;
  std::size_t degraded = 0;
  std::size_t doubtful = 0;
  std::size_t degenerate = 0;
  /// Squared error of the probability that a step is right, summed over `steps` steps without lost
  /// ones.
  double squared_error = 0.0;
  std::size_t steps = 0;
  double cpu_ms = 0.0;       ///< per scan
  double path_length = 0.0;  ///< m
  double ape = 0.0;          ///< m, root mean square after alignment
  /// Mean normalised error squared per degree of freedom, of steps and of motions between key
  /// frames (MotionErrors); none where the front end claimed none.
  std::optional<double> nees_steps;
  std::optional<double> nees_edges;
};

/// Simulates the case and runs the front end over `duration` seconds of it; every step goes into
/// `steps` where that is given. Throws ConfigError, also if these are less than three scans.
CampaignFigures run_case(const CampaignCase& campaign_case, double duration,
                         std::vector<CheckedStep>* steps = nullptr);

}  // namespace lidar_mapping::campaign
