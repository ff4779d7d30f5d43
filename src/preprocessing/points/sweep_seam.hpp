// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/preprocessing/input_validator.hpp"

namespace lidar_mapping::preprocessing {

/// Distinguishes raw scans from scans that were motion-compensated before, by the seam of the
/// sweep. In raw scans the end of a sweep joins the beginning of the next sweep, which is measured
/// from the same place a moment later. In compensated scans it joins the beginning of its own
/// sweep. If the times run backwards the beginning of a sweep joins the end of the next one, since
/// each is taken for the other. If the vehicle stands still, nothing can be decided.
class SweepSeam {
 public:
  void add(const CloudSummary& cloud);
  /// True if many scans indicate compensation, and hardly any scan indicates raw data.
  bool is_compensated() const;
  /// True if many scans indicate that the times of their points run backwards.
  bool is_reversed() const;

 private:
  CloudSummary previous_;
  std::size_t raw_ = 0;          ///< scans that speak for it
  std::size_t compensated_ = 0;  ///< scans that speak for it
  std::size_t reversed_ = 0;     ///< scans that speak for it
};

}  // namespace lidar_mapping::preprocessing
