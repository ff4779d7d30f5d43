// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>

#include "gnss/local_frame.hpp"

namespace lidar_mapping::preprocessing {

/// Measures the noise of fixes: changes from fix to fix that are faster than any vehicle. It is
/// computed from the median of the second differences p(i) - 2 p(i-1) + p(i-2), with at least four
/// fixes per second.
class FixScatter {
 public:
  /// Adds fixes in the order of their stamps. Jumps have little influence.
  void add(const LocalFix& fix);

  bool is_known() const;
  /// Horizontal standard deviation, as measured and as stated by the covariances, m: the root of
  /// the sum of both axes' variances, which is the root mean square of the error's length.
  double measured() const;
  double stated() const;
  /// Factor by which the stated covariances are too small; 1 if they are not, or if this cannot be
  /// measured. As long as the scatter is not known, the factor that raises the standard deviation
  /// to one metre.
  double variance_factor() const;

 private:
  /// Second differences; chosen: more are steadier, but notice a change of the sky later.
  static constexpr std::size_t kMaxCount = 200;

  std::deque<LocalFix> last_fixes_;        ///< up to three
  std::deque<double> second_differences_;  ///< m
  std::deque<double> sigmas_;              ///< m
};

}  // namespace lidar_mapping::preprocessing
