// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

// Weights of iteratively reweighted least squares (Zhang 1997, Parameter estimation techniques,
// table 1): 1 for a residual of zero. `residual` and `scale` have the same unit; `scale` is
// positive.

/// Weight of Tukey's biweight, 0 to 1 (Zhang 1997, Parameter estimation techniques, table 1):
/// residuals beyond `scale` (same unit, positive) do not count at all.
inline double tukey_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double rest = 1.0 - ratio * ratio;
  return rest <= 0.0 ? 0.0 : rest * rest;
}

/// Weight of Geman and McClure, 0 to 1 (Zhang 1997, table 1): a quarter is left at `scale` (unit of
/// the residual, positive), and next to nothing far beyond.
inline double geman_mcclure_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double root = 1.0 / (1.0 + ratio * ratio);
  return root * root;
}

}  // namespace lidar_mapping
