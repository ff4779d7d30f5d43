// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/robust_weights.hpp"

namespace lidar_mapping {
namespace {

TEST(RobustWeights, AreOneWithoutAResidual) {
  EXPECT_EQ(tukey_weight(0.0, 0.1), 1.0);
  EXPECT_EQ(geman_mcclure_weight(0.0, 0.1), 1.0);
}

TEST(RobustWeights, DoNotDependOnTheSign) {
  EXPECT_EQ(tukey_weight(-0.3, 1.0), tukey_weight(0.3, 1.0));
  EXPECT_EQ(geman_mcclure_weight(-0.3, 1.0), geman_mcclure_weight(0.3, 1.0));
}

TEST(RobustWeights, OfTukeyEndAtTheScale) {
  EXPECT_DOUBLE_EQ(tukey_weight(0.5, 1.0), 0.5625);
  EXPECT_EQ(tukey_weight(1.0, 1.0), 0.0);
  EXPECT_EQ(tukey_weight(50.0, 1.0), 0.0);
}

TEST(RobustWeights, OfGemanAndMcClureAreAQuarterAtTheScale) {
  EXPECT_DOUBLE_EQ(geman_mcclure_weight(2.0, 2.0), 0.25);
  EXPECT_LT(geman_mcclure_weight(20.0, 2.0), 1e-4);
}

TEST(RobustWeights, OfGemanAndMcClureAreTheSameFromSquares) {
  EXPECT_EQ(geman_mcclure_weight_of_squares(0.0, 0.01), 1.0);
  for (const double residual : {0.01, 0.3, 2.0, 50.0}) {
    EXPECT_DOUBLE_EQ(geman_mcclure_weight_of_squares(residual * residual, 4.0),
                     geman_mcclure_weight(residual, 2.0));
  }
}

}  // namespace
}  // namespace lidar_mapping
