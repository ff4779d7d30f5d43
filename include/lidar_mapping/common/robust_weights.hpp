// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

/// Weight of Tukey's biweight in iteratively reweighted least squares (Zhang 1997, Parameter
/// estimation techniques, table 1): 1 for a residual of zero, and 0 beyond `scale`, which has the
/// residual's unit and is positive.
inline double tukey_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double rest = 1.0 - ratio * ratio;
  return rest <= 0.0 ? 0.0 : rest * rest;
}

/// Weight of Geman and McClure (Zhang 1997, table 1): 1 for a residual of zero, a quarter at
/// `scale` (in the residual's unit, positive), and next to nothing far beyond.
inline double geman_mcclure_weight(double residual, double scale) {
  const double ratio = residual / scale;
  const double root = 1.0 / (1.0 + ratio * ratio);
  return root * root;
}

/// The same weight from the squares of residual and scale; the last bits differ.
inline double geman_mcclure_weight_of_squares(double squared_residual, double squared_scale) {
  const double root = squared_scale / (squared_scale + squared_residual);
  return root * root;
}

}  // namespace lidar_mapping
