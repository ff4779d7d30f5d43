// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/order_statistics.hpp"

namespace lidar_mapping {
namespace {

const std::vector<double> kValues = {5.0, 1.0, 4.0, 2.0, 3.0};

TEST(Quantile, IsOneOfTheValues) {
  EXPECT_EQ(quantile(kValues, 0.0), 1.0);
  EXPECT_EQ(quantile(kValues, 0.5), 3.0);
  EXPECT_EQ(quantile(kValues, 0.79), 4.0);
  EXPECT_EQ(quantile(kValues, 1.0), 5.0);
}

TEST(Quantile, OfTwoInTheMiddleIsTheGreater) { EXPECT_EQ(median(std::vector<int>{4, 1, 3, 2}), 3); }

TEST(Quantile, OfNothingIsZero) { EXPECT_EQ(quantile(std::vector<float>{}, 0.5), 0.0F); }

TEST(Quantile, OfARangeLooksAtNothingElse) {
  std::vector<int> values = {3, 2, 1, -7, -8};
  EXPECT_EQ(quantile_of_range(values.begin(), values.begin() + 3, 0.0), 1);
}

}  // namespace
}  // namespace lidar_mapping
