// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "local_frame.hpp"

namespace lidar_mapping::preprocessing {

/// What changes from fix to fix faster than a vehicle can is noise: the median of the bends
/// p(i) - 2 p(i-1) + p(i-2) of at least four fixes a second tells how much there is.
class FixScatter {
 public:
  /// Fixes in the order of their stamps; jumps hardly count.
  void add(const LocalFix& fix);
  void clear() { *this = {}; }

  bool is_known() const;
  /// Horizontal scatter and what the covariances say it is, root mean square of both axes, m.
  double measured() const;
  double stated() const;
  /// By how much covariances are too small; 1 where they are not, or where it cannot be known.
  /// While it is being found out, what makes them a metre.
  double variance_factor() const;

 private:
  static constexpr std::size_t kMaxCount = 200;

  std::deque<LocalFix> last_fixes_;        ///< up to three
  std::deque<double> second_differences_;  ///< m
  std::deque<double> sigmas_;              ///< m
};

}  // namespace lidar_mapping::preprocessing
