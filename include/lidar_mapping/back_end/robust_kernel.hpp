#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <ceres/loss_function.h>

namespace lidar_mapping::back_end {

/// How a residual's pull ends when it grows. The size is in standard deviations.
enum class RobustKernel { kNone, kHuber, kCauchy, kDcs, kGemanMcClure };

/// The names in configuration files and on command lines, with their kernels.
const std::vector<std::pair<std::string, RobustKernel>>& robust_kernel_names();

/// The kernel as a loss on the squared whitened norm; null for kNone. `size` is where it starts to
/// bend: Huber's and Cauchy's scale; for DCS (Agarwal 2013) and Geman-McClure its square is the
/// constant Phi and c^2 of doc/back_end.md.
std::unique_ptr<ceres::LossFunction> make_kernel(RobustKernel kernel, double size);

/// The 99 % quantile of chi-square with 1 to 6 degrees of freedom: above it a constraint counts as
/// contradicted by the others.
double contradiction_limit(int degrees_of_freedom);

}  // namespace lidar_mapping::back_end
