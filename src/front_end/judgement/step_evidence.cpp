// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/step_evidence.hpp"

namespace lidar_mapping::front_end {

std::vector<std::pair<const char*, double>> named_figures(const StepEvidence& e) {
  return {{"points", e.points},
          {"overlap", e.overlap},
          {"pair_quality", e.pair_quality},
          {"residual_variance", e.residual_variance},
          {"converged", e.converged},
          {"iterations", e.iterations},
          {"rescued", e.rescued},
          {"degenerate", e.degenerate},
          {"seconds", e.seconds},
          {"sigma", e.sigma},
          {"sigma_angle", e.sigma_angle},
          {"surprise", e.surprise},
          {"surprise_angle", e.surprise_angle},
          {"surprise_sigmas", e.surprise_sigmas},
          {"disagreement", e.disagreement},
          {"disagreement_angle", e.disagreement_angle},
          {"disagreement_sigmas", e.disagreement_sigmas},
          {"unsteadiness", e.motion_change},
          {"unsteadiness_angle", e.motion_change_angle},
          {"sweep_gap", e.sweep_gap},
          {"sweep_gap_angle", e.sweep_gap_angle},
          {"turn", e.turn},
          {"sectors", e.sectors}};
}

}  // namespace lidar_mapping::front_end
