// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/preprocessing/input_validator.hpp"

namespace lidar_mapping::preprocessing {

/// Tells scans as they were measured from scans whose motion was taken out already, by the seam of
/// the sweep. Where the motion is still in, the end of a sweep joins the beginning of the next one,
/// measured from the same place a moment later; where it was taken out, it joins the beginning of
/// its own. Standing vehicles tell nothing.
class SweepSeam {
 public:
  void add(const CloudSummary& cloud);
  /// Many scans speak for it, and hardly any against.
  bool is_compensated() const;

 private:
  CloudSummary previous_;
  std::size_t raw_ = 0;          ///< scans that speak for it
  std::size_t compensated_ = 0;  ///< scans that speak for it
};

}  // namespace lidar_mapping::preprocessing
