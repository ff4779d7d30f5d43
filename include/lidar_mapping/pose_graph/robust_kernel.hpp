// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <ceres/loss_function.h>

namespace lidar_mapping::pose_graph {

/// How a residual's pull ends when it grows. The size is in standard deviations.
enum class RobustKernel {
  kNone,
  kHuber,
  kPseudoHuber,
  kCauchy,
  kDcs,
  kFair,
  kGemanMcClure,
  kSaturated,
  kTukey,
  kWelsch
};

/// The names in configuration files and on command lines, with their kernels: those of g2o and
/// hdl_graph_slam. Case does not matter where they are read.
const std::vector<std::pair<std::string, RobustKernel>>& robust_kernel_names();

/// The kernel of a name, in any case. Throws InputError with all names for another one.
RobustKernel robust_kernel_of(const std::string& name);

/// The kernel as a loss on the squared whitened norm; null for kNone. `size` is where it starts to
/// bend: the scale c of doc/back_end.md; for DCS (Agarwal 2013) and Geman-McClure its square is the
/// constant Phi and c^2 there. All have slope 1 at zero.
std::unique_ptr<ceres::LossFunction> make_kernel(RobustKernel kernel, double size);

/// The 99 % quantile of chi-square with 1 to 6 degrees of freedom: above it a constraint counts as
/// contradicted by the others. Throws InputError for another number.
double chi2_limit(int degrees_of_freedom);

}  // namespace lidar_mapping::pose_graph
