// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

namespace lidar_mapping {

/// Standard deviation of a normal distribution divided by the median of the absolute deviations
/// (MAD): 1 / (the 75 % quantile of the standard normal distribution).
constexpr double kSigmaPerMad = 1.4826;

/// The value that a `fraction` (0 to 1) of those in [begin, end) lie below, without interpolation:
/// one of the values, of two in the middle the greater. Reorders the range, which may not be empty.
template <typename Iterator>
typename std::iterator_traits<Iterator>::value_type quantile_of_range(Iterator begin, Iterator end,
                                                                      double fraction) {
  const auto count = static_cast<std::size_t>(std::distance(begin, end));
  const auto rank = static_cast<std::size_t>(fraction * static_cast<double>(count));
  const auto at = begin + static_cast<std::ptrdiff_t>(std::min(rank, count - 1));
  std::nth_element(begin, at, end);
  return *at;
}

/// quantile_of_range() of a copy of the values; 0 of no values.
template <typename T>
T quantile(std::vector<T> values, double fraction) {
  return values.empty() ? T{} : quantile_of_range(values.begin(), values.end(), fraction);
}

/// quantile(values, 0.5); 0 of no values.
template <typename T>
T median(std::vector<T> values) {
  return quantile(std::move(values), 0.5);
}

}  // namespace lidar_mapping
