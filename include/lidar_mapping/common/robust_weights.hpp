// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

/// Weights of iteratively reweighted least squares (Zhang 1997, Parameter estimation techniques,
/// table 1): 1 for a residual of zero. `residual` and `scale` have the same unit; `scale` is
/// positive.

/// Tukey's biweight: residuals beyond `scale` do not count at all.
inline double tukey_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double rest = 1.0 - ratio * ratio;
  return rest <= 0.0 ? 0.0 : rest * rest;
}

/// Geman and McClure's: a quarter is left at `scale`, and next to nothing far beyond.
inline double geman_mcclure_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double root = 1.0 / (1.0 + ratio * ratio);
  return root * root;
}

}  // namespace lidar_mapping
