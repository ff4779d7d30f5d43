// SPDX-License-Identifier: BSD-3-Clause
// What is known of two key frames before they are matched, with numbers for which the root is
// whole.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "candidates/prior.hpp"
#include "drive.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A straight road of key frames every 10 m; `distances` knows no loop.
struct Road {
  explicit Road(std::size_t count, double gap = 10.0) {
    for (std::size_t i = 0; i < count; ++i) {
      trajectory.append(key_frame(i, planar(10.0 * static_cast<double>(i), 0.0, 0.0)));
      distances.append(i == 0 ? 0.0 : gap);
    }
  }
  Prior prior(std::size_t from, std::size_t to, const LoopClosingConfig& config = {}) const {
    return prior_between(trajectory, distances, from, to, config);
  }
  Trajectory trajectory;
  GraphDistance distances;
};

TEST(Prior, IsTheRelativePoseWithTheDriftOfItsDistance) {
  LoopClosingConfig config;
  config.horizontal_drift = 0.02;
  config.vertical_drift = 0.003;
  config.rotation_drift = 1.5 * kRadPerDeg / 100.0;
  const Road road(26);
  const Prior prior = road.prior(0, 25, config);
  EXPECT_TRUE(prior.anchored);
  EXPECT_TRUE(near(prior.T_from_to, planar(250.0, 0.0, 0.0), 1e-9));
  EXPECT_NEAR(prior.sigma_horizontal, 0.02 * 250.0, 1e-9);
  EXPECT_NEAR(prior.sigma_vertical, 0.003 * 250.0 * 0.5, 1e-9) << "250 m are a quarter of 1 km";
  EXPECT_NEAR(prior.sigma_rotation, 2.5 * 1.5 * kRadPerDeg, 1e-9) << "per 100 m";
  EXPECT_FALSE(prior.gnss);
}

TEST(Prior, IsUnknownForUnconnectedSegments) {
  const Prior prior = Road(3, kInfinite).prior(0, 2);
  EXPECT_FALSE(prior.anchored);
  EXPECT_EQ(prior.sigma_horizontal, kInfinite);
  EXPECT_EQ(prior.sigma_vertical, kInfinite);
  EXPECT_EQ(prior.sigma_rotation, kInfinite);
}

TEST(Prior, HasAHeadingWithinHalfATurn) {
  LoopClosingConfig config;
  config.rotation_drift = kRadPerDeg;  // a turn in 360 m
  EXPECT_NEAR(Road(30).prior(0, 29, config).sigma_rotation, kPi, 1e-12);
}

GnssPosition position_of(std::size_t key, const Eigen::Vector3d& p, double sigma) {
  GnssPosition position;
  position.stamp = key_frame(key, Pose()).stamp;
  position.p_enu_antenna = p;
  position.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return position;
}

TEST(Prior, HasTheDistanceByGnssIfBothHaveAPosition) {
  Road road(3);
  road.trajectory.add_gnss(position_of(0, {100.0, 200.0, 5.0}, 2.0));
  EXPECT_FALSE(road.prior(0, 2).gnss) << "of one alone";
  road.trajectory.add_gnss(position_of(2, {103.0, 204.0, 900.0}, 2.0));
  const Prior prior = road.prior(0, 2);
  ASSERT_TRUE(prior.gnss);
  EXPECT_NEAR(prior.gnss->value, 5.0, 1e-9) << "3-4-5, level";
  EXPECT_NEAR(prior.gnss->sigma, 3.0, 1e-9) << "4 + 4 of the fixes and 1 in any case";
  LoopClosingConfig config;
  config.gnss_candidates = false;
  EXPECT_FALSE(road.prior(0, 2, config).gnss);
}

// Without a heading nobody knows on which side of the vehicle the antenna is.
TEST(Prior, AddsALeverArmOfUnknownDirectionToTheDistanceByGnss) {
  Road road(3);
  GnssPosition a = position_of(0, {0.0, 0.0, 0.0}, 0.0);
  GnssPosition b = position_of(2, {8.0, 0.0, 0.0}, 0.0);
  a.p_base_antenna = {2.0, 0.0, 1.0};
  b.p_base_antenna = {0.0, -2.0, 1.0};
  road.trajectory.add_gnss(a);
  road.trajectory.add_gnss(b);
  EXPECT_NEAR(road.prior(0, 2).gnss->sigma, 3.0, 1e-9) << "1 + 4 + 4";

  Road known(3);
  a.R_enu_base = b.R_enu_base = Eigen::Quaterniond::Identity();
  b.p_base_antenna = {-1.0, 0.0, 1.0};
  known.trajectory.add_gnss(a);
  known.trajectory.add_gnss(b);
  EXPECT_NEAR(known.prior(0, 2).gnss->sigma, 1.0, 1e-9);
  EXPECT_NEAR(known.prior(0, 2).gnss->value, 11.0, 1e-9) << "from -2 m to 9 m";
}

Prior anchored_at(const Pose& T_from_to, double horizontal, double vertical = 0.0) {
  Prior prior;
  prior.anchored = true;
  prior.T_from_to = T_from_to;
  prior.sigma_horizontal = horizontal;
  prior.sigma_vertical = vertical;
  prior.sigma_rotation = 0.0;
  return prior;
}

TEST(GnssIsMoreCertain, IfTheEstimateIsLessCertainOrUnknown) {
  Prior prior = anchored_at(Pose(), 5.0);
  EXPECT_FALSE(gnss_is_more_certain(prior)) << "there is none";
  prior.gnss = Distance{10.0, 4.0};
  EXPECT_TRUE(gnss_is_more_certain(prior));
  prior.gnss->sigma = 6.0;
  EXPECT_FALSE(gnss_is_more_certain(prior));
  prior.anchored = false;
  EXPECT_TRUE(gnss_is_more_certain(prior));
}

class MayOverlap : public testing::Test {
 protected:
  MayOverlap() {
    config_.detect_area = 10.0;
    config_.distance_thresh = 100.0;
  }
  bool at(double distance, double sigma) const {
    return may_overlap(anchored_at(planar(0.0, distance, 0.0), sigma), config_);
  }
  bool at_height(double height, double sigma, double distance = 0.0) const {
    return may_overlap(anchored_at(planar(distance, 0.0, 0.0, height), 100.0, sigma), config_);
  }
  LoopClosingConfig config_;
};

TEST_F(MayOverlap, WithinTheAreaAndThreeStandardDeviations) {
  EXPECT_TRUE(at(9.9, 0.0));
  EXPECT_FALSE(at(10.1, 0.0));
  EXPECT_TRUE(at(10.0 + 3.02 * 5.0, 5.0)) << "99 % of a distance in the plane are within 3.03";
  EXPECT_FALSE(at(10.0 + 3.04 * 5.0, 5.0));
}

TEST_F(MayOverlap, WithinTheLimitHoweverUncertain) {
  EXPECT_TRUE(at(99.0, 1e3));
  EXPECT_FALSE(at(101.0, 1e3));
}

TEST_F(MayOverlap, OnTheSameStorey) {
  EXPECT_TRUE(at_height(0.59, 0.0));
  EXPECT_FALSE(at_height(0.61, 0.0));
  EXPECT_FALSE(at_height(-0.61, 0.0)) << "below";
  EXPECT_TRUE(at_height(0.6 + 3.0, 1.0)) << "three standard deviations";
  EXPECT_FALSE(at_height(0.6 + 3.1, 1.0));
  EXPECT_TRUE(at_height(2.59, 0.0, 20.0)) << "a street may climb by 2 m in 20 m";
  EXPECT_FALSE(at_height(2.61, 0.0, 20.0));
}

TEST_F(MayOverlap, ByGnssWhereThatIsMoreCertain) {
  Prior prior = anchored_at(planar(90.0, 0.0, 0.0), 20.0);
  EXPECT_FALSE(may_overlap(prior, config_));
  prior.gnss = Distance{12.0, 1.0};
  EXPECT_TRUE(may_overlap(prior, config_));
  prior.gnss = Distance{14.0, 1.0};
  EXPECT_FALSE(may_overlap(prior, config_));
  prior.gnss = Distance{12.0, 25.0};
  EXPECT_FALSE(may_overlap(prior, config_)) << "the estimate is more certain";
}

TEST_F(MayOverlap, IfNothingIsKnown) {
  Prior prior;
  prior.T_from_to = planar(5000.0, 0.0, 0.0, 300.0);
  EXPECT_TRUE(may_overlap(prior, config_));
  prior.gnss = Distance{500.0, 1.0};
  EXPECT_FALSE(may_overlap(prior, config_));
  prior.gnss = Distance{5.0, 1.0};
  EXPECT_TRUE(may_overlap(prior, config_)) << "its height is not known";
}

TEST_F(MayOverlap, NeverBeyondTheLargestRadius) {
  config_.horizontal_drift = 0.01;
  EXPECT_NEAR(largest_radius(0.0, config_), 10.0, 1e-12);
  EXPECT_NEAR(largest_radius(1000.0, config_), 10.0 + 3.03 * 10.0, 1e-9);
  EXPECT_NEAR(largest_radius(1e6, config_), 100.0, 1e-12);
  EXPECT_TRUE(at(largest_radius(1000.0, config_) - 0.01, 0.01 * 1000.0));
  EXPECT_FALSE(at(largest_radius(1000.0, config_) + 0.01, 0.01 * 1000.0));
}

// Standard deviations of 1.2 m and 0.5 m are 1.3 m together, 0.4 m and 0.3 m are 0.5 m, and
// 0.03 rad and 0.04 rad are 0.05 rad.
TEST(InnovationOf, IsTheSquaredDistanceInStandardDeviations) {
  Prior prior = anchored_at(planar(4.0, 1.0, 0.5), 1.2, 0.4);
  prior.sigma_rotation = 0.03;
  const auto innovation = [&](const Vector6d& d) {
    return innovation_of(prior, perturbed(prior.T_from_to, d));
  };
  EXPECT_NEAR(innovation(Vector6d::Zero()).whole, 0.0, 1e-9);
  const Innovation level = innovation(Vector6d::Unit(0) * 2.6);
  EXPECT_NEAR(level.whole, 4.0, 1e-9);
  EXPECT_NEAR(level.height, 0.0, 1e-9);
  const Innovation up = innovation(Vector6d::Unit(2) * -1.5);
  EXPECT_NEAR(up.whole, 9.0, 1e-9);
  EXPECT_NEAR(up.height, 9.0, 1e-9);
  for (const int axis : {3, 4, 5}) {
    EXPECT_NEAR(innovation(Vector6d::Unit(axis) * 0.1).whole, 4.0, 1e-6) << axis;
  }
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
