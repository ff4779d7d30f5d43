// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ceres {
class LossFunction;
}  // namespace ceres

namespace lidar_mapping::pose_graph {

/// Robust kernels: how the influence of a residual is limited when it grows. Their sizes are in
/// standard deviations; the formulas are in doc/back_end.md.
enum class RobustKernel {
  kNone,          ///< least squares
  kHuber,         ///< quadratic up to the size, linear beyond (Huber 1964)
  kPseudoHuber,   ///< smooth approximation of Huber's kernel
  kCauchy,        ///< grows with the logarithm
  kDcs,           ///< dynamic covariance scaling (Agarwal et al. 2013)
  kFair,          ///< grows linearly, with continuous derivatives
  kGemanMcClure,  ///< bounded, the influence falls to zero
  kSaturated,     ///< quadratic up to the size, constant beyond
  kTukey,         ///< biweight: bounded, no influence beyond the size
  kWelsch         ///< bounded, the influence falls exponentially
};

/// The names of all kernels in configuration files and on command lines. They are those of g2o and
/// hdl_graph_slam. Upper and lower case are not distinguished when a name is read.
const std::vector<std::pair<std::string, RobustKernel>>& robust_kernel_names();

/// The kernel with this name in upper or lower case. Throws InputError with a list of all names if
/// there is none.
RobustKernel robust_kernel_of(const std::string& name);

/// The kernel as a loss function of the squared whitened norm; null for kNone. `size` is the scale
/// c of doc/back_end.md in standard deviations; its square is the constant Phi of DCS. The
/// derivative of all losses is 1 at zero. Callers include <ceres/loss_function.h>.
std::unique_ptr<ceres::LossFunction> make_kernel(RobustKernel kernel, double size);

/// Value and derivative of a loss at a squared norm; of least squares if it is null.
std::pair<double, double> loss_at(const ceres::LossFunction* loss, double squared_norm);

/// The 99 % quantile of the chi-square distribution with 1 to 6 degrees of freedom. The limits
/// above which other constraints contradict a constraint are derived from it. Throws InputError for
/// other degrees of freedom.
double chi2_limit(int degrees_of_freedom);

}  // namespace lidar_mapping::pose_graph
