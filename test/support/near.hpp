// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::test {

/// The numbers of a column in one line, of a matrix in one line per row.
template <typename Derived>
std::string shown(const Eigen::DenseBase<Derived>& values) {
  const bool is_column = values.cols() == 1;
  const Eigen::IOFormat format(12, is_column ? Eigen::DontAlignCols : 0, ", ",
                               is_column ? ", " : "\n ", is_column ? "" : "[", is_column ? "" : "]",
                               "[", "]");
  std::ostringstream text;
  text << values.format(format);
  return text.str();
}

/// Translation and rotation vector of a pose.
inline std::string shown(const Pose& pose) {
  return shown(pose.translation) + " m, " + shown(log_so3(pose.rotation)) + " rad";
}

/// A failure whose message says how far apart the two are, then shows them.
template <typename Actual, typename Expected>
testing::AssertionResult not_near(const std::string& distance, const Actual& actual,
                                  const Expected& expected) {
  return testing::AssertionFailure()
         << distance << "\n  actual: " << shown(actual) << "\nexpected: " << shown(expected);
}

/// Succeeds if two vectors or matrices differ by less than `tolerance`: the norm of their
/// difference, of matrices Frobenius's, in the unit of their numbers. Nothing is near to NaN, as no
/// NaN is less than a tolerance. For use as `EXPECT_TRUE(near(actual, expected, 1e-9))`.
template <typename Actual, typename Expected>
testing::AssertionResult near(const Eigen::MatrixBase<Actual>& actual,
                              const Eigen::MatrixBase<Expected>& expected, double tolerance) {
  // Evaluated once: an expression may be costly.
  const auto a = actual.eval();
  const auto e = expected.eval();
  if (a.rows() != e.rows() || a.cols() != e.cols()) return not_near("the sizes differ", a, e);
  const double distance = static_cast<double>((a - e).norm());
  if (distance < tolerance) return testing::AssertionSuccess();
  std::ostringstream text;
  text << "the distance " << distance << " is not less than " << tolerance;
  return not_near(text.str(), a, e);
}

/// Succeeds if the norm of the six numbers of difference() is less than `tolerance`: metres and
/// radians together, as if they were one unit.
inline testing::AssertionResult near(const Pose& actual, const Pose& expected, double tolerance) {
  const double distance = difference(expected, actual).norm();
  if (distance < tolerance) return testing::AssertionSuccess();
  std::ostringstream text;
  text << "the distance " << distance << " (m and rad) is not less than " << tolerance;
  return not_near(text.str(), actual, expected);
}

/// Succeeds if two poses are less than `tolerance_m` metres and less than `tolerance_rad` radians
/// apart.
inline testing::AssertionResult near(const Pose& actual, const Pose& expected, double tolerance_m,
                                     double tolerance_rad) {
  const Vector6d d = difference(expected, actual);
  const double metres = d.head<3>().norm();
  const double radians = d.tail<3>().norm();
  if (metres < tolerance_m && radians < tolerance_rad) return testing::AssertionSuccess();
  std::ostringstream text;
  text << "the distance " << metres << " m and " << radians << " rad is not less than "
       << tolerance_m << " m and " << tolerance_rad << " rad";
  return not_near(text.str(), actual, expected);
}

}  // namespace lidar_mapping::test
