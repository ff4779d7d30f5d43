// SPDX-License-Identifier: BSD-3-Clause
// Positions, headings and floors as constraints, with numbers that are told by hand.

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/unknown_height.hpp"

#include "factors/floor_factors.hpp"
#include "gnss/gnss_factors.hpp"
#include "gnss/gnss_weights.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(GnssWeights, ContainTheLeastStandardDeviations) {
  GnssPosition position;
  position.covariance << 1.75, 0.3, 0.0, 0.3, 5.75, 0.0, 0.0, 0.0, 9.0;
  BackEndConfig config;
  config.gnss_min_stddev_m = 0.5;
  config.gnss_min_stddev_altitude_m = 4.0;
  const Eigen::Matrix2d expected = (Eigen::Matrix2d() << 2.0, 0.3, 0.3, 6.0).finished();
  EXPECT_TRUE(test::near(horizontal_covariance(position, config), expected, 1e-12));
  EXPECT_NEAR(horizontal_stddev(position, config), 2.0, 1e-12) << "the mean of both variances";
  EXPECT_NEAR(altitude_stddev(position, config), 5.0, 1e-12);
}

TEST(GnssWeights, ShowWhetherAnAltitudeWasMeasured) {
  const auto is_known = [](double altitude, double variance) {
    GnssPosition position;
    position.p_enu_antenna.z() = altitude;
    position.covariance(2, 2) = variance;
    return has_altitude(position);
  };
  const double unknown = kUnknownHeightStddev * kUnknownHeightStddev;
  EXPECT_TRUE(is_known(-12.0, 4.0));
  EXPECT_TRUE(is_known(0.0, 0.99 * unknown));
  EXPECT_FALSE(is_known(0.0, unknown));
  EXPECT_FALSE(is_known(0.0, 0.0));
  EXPECT_FALSE(is_known(0.0, -1.0));
  EXPECT_FALSE(is_known(0.0, kNan));
  EXPECT_FALSE(is_known(kNan, 4.0));
  EXPECT_FALSE(is_known(kInfinite, 4.0));
}

/// A straight drive in East-North-Up with a position every so many metres, 3 m beside the road and
/// 4 m above it, of 1 m.
class GnssFactors : public testing::Test {
 protected:
  GnssFactors() {
    config_.gnss_min_stddev_m = 0.0;
    config_.gnss_min_stddev_altitude_m = 0.0;
    config_.gnss_correlation_distance = 10.0;
  }
  void drive(const std::vector<double>& way) {
    for (std::size_t i = 0; i < way.size(); ++i) {
      DriveNode node;
      node.connected = i > 0;
      node.stamp = from_seconds(static_cast<double>(i));
      node.T_odom_base.translation.x() = way[i];
      node.T_map_base = node.T_odom_base;
      drive_.nodes.push_back(node);
      DriveGnss gnss;
      gnss.node = static_cast<int>(i);
      gnss.position.p_enu_antenna = {way[i], 3.0, 4.0};
      drive_.gnss.push_back(gnss);
    }
    drive_.in_enu = {true};
    drive_.gnss_delays = {GnssDelay{0.0, 0.0}};
  }
  DriveFactors factors() const {
    DriveFactors result;
    for (const DriveNode& node : drive_.nodes) result.graph.add_node(node.T_map_base);
    result.horizontal_of.assign(drive_.gnss.size(), -1);
    result.altitude_of.assign(drive_.gnss.size(), -1);
    add_gnss(drive_, config_, result);
    return result;
  }
  /// Squared errors in standard deviations; 0 without a constraint.
  static std::vector<double> squares(const DriveFactors& made, const std::vector<int>& of) {
    std::vector<double> result;
    for (const int i : of) {
      const auto number = static_cast<std::size_t>(i);
      result.push_back(i < 0 ? 0.0 : chi2(made.graph, made.graph.constraints[number]));
    }
    return result;
  }
  void expect_squares(const std::vector<double>& horizontal, const std::vector<double>& altitude) {
    const DriveFactors made = factors();
    const std::vector<double> of_plane = squares(made, made.horizontal_of);
    const std::vector<double> of_height = squares(made, made.altitude_of);
    ASSERT_EQ(of_plane.size(), horizontal.size());
    for (std::size_t i = 0; i < horizontal.size(); ++i) {
      EXPECT_NEAR(of_plane[i], horizontal[i], 1e-9) << i;
      EXPECT_NEAR(of_height[i], altitude[i], 1e-9) << i;
    }
  }

  DriveGraph drive_;
  BackEndConfig config_;
};

TEST_F(GnssFactors, HaveFullWeightsFarFromEachOther) {
  drive({0.0, 12.0, 30.0});
  expect_squares({9.0, 9.0, 9.0}, {16.0, 16.0, 16.0});
}

// Of five positions on ten metres, each has a fifth of its weight.
TEST_F(GnssFactors, HaveReducedWeightsNearEachOther) {
  drive({0.0, 2.0, 4.0, 6.0});
  expect_squares({1.8, 1.8, 1.8, 1.8}, {3.2, 3.2, 3.2, 3.2});
}

TEST_F(GnssFactors, HaveWeightsByTheMeanDistanceToBothNeighbours) {
  drive({0.0, 2.0, 8.0});
  expect_squares({9.0 / 5.0, 9.0 / 2.5, 9.0 * 0.6}, {16.0 / 5.0, 16.0 / 2.5, 16.0 * 0.6});
}

TEST_F(GnssFactors, HaveAHundredthOfTheirWeightAtRest) {
  drive({5.0, 5.0, 5.0});
  expect_squares({0.09, 0.09, 0.09}, {0.16, 0.16, 0.16});
}

TEST_F(GnssFactors, AreLeftOutWhereNothingIsMeasured) {
  drive({0.0, 12.0, 30.0});
  drive_.gnss[1].position.p_enu_antenna.z() = kNan;
  expect_squares({9.0, 9.0, 9.0}, {16.0, 0.0, 16.0});
  EXPECT_EQ(factors().altitude_of[1], -1);
  drive_.in_enu = {false};
  expect_squares({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(factors().graph.constraints.empty());
}

TEST_F(GnssFactors, HaveHeadingsThatCameWithThem) {
  drive({0.0, 12.0, 30.0});
  config_.imu_heading_stddev = 2.0 * kRadPerDeg;
  drive_.gnss[1].position.R_enu_base = exp_so3({0.0, 0.0, 6.0 * kRadPerDeg});
  pose_graph::FactorGraph graph;
  for (const DriveNode& node : drive_.nodes) graph.add_node(node.T_map_base);
  add_headings(drive_, config_, graph);
  ASSERT_EQ(graph.constraints.size(), 1U);
  EXPECT_EQ(graph.constraints[0].first, 1);
  EXPECT_NEAR(chi2(graph, graph.constraints[0]), 9.0, 0.1) << "three standard deviations";
  drive_.in_enu = {false};
  add_headings(drive_, config_, graph);
  EXPECT_EQ(graph.constraints.size(), 1U) << "the map does not look north";
}

/// Five key frames that roll a little; the fourth one begins a segment. All but the third one have
/// seen the floor, half a metre below.
class FloorFactors : public testing::Test {
 protected:
  FloorFactors() {
    for (int i = 0; i < 5; ++i) {
      DriveNode node;
      node.connected = i != 0 && i != 3;
      node.T_map_base = {exp_so3({0.02 * i, 0.0, 0.0}), {1.0 * i, 0.0, 0.5}};
      drive_.nodes.push_back(node);
      if (i == 2) continue;
      Floor floor;
      floor.normal = node.T_map_base.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      floor.offset = 0.5;
      drive_.floors.push_back({floor, i});
    }
  }
  pose_graph::FactorGraph graph(FloorConstraint constraint) const {
    pose_graph::FactorGraph result;
    for (const DriveNode& node : drive_.nodes) result.add_node(node.T_map_base);
    BackEndConfig config;
    config.floor_constraint = constraint;
    add_floors(drive_, config, result);
    return result;
  }

  DriveGraph drive_;
};

double whole_chi2(const pose_graph::FactorGraph& graph) {
  return total_chi2(graph, std::vector<bool>(graph.constraints.size(), true));
}

TEST_F(FloorFactors, JoinNeighboursThatOdometryConnects) {
  const pose_graph::FactorGraph pairs = graph(FloorConstraint::kNeighbours);
  ASSERT_EQ(pairs.constraints.size(), 2U);
  EXPECT_EQ(pairs.constraints[0].first, 0);
  EXPECT_EQ(pairs.constraints[0].second, 1);
  EXPECT_EQ(pairs.constraints[1].first, 3);
  EXPECT_EQ(pairs.constraints[1].second, 4);
  EXPECT_NEAR(whole_chi2(pairs), 0.0, 1e-9);
  EXPECT_TRUE(graph(FloorConstraint::kNone).constraints.empty());
}

TEST_F(FloorFactors, JoinAllWithOnePlane) {
  const pose_graph::FactorGraph plane = graph(FloorConstraint::kPlane);
  ASSERT_EQ(plane.states.size(), 6U) << "a node for the plane";
  ASSERT_EQ(plane.constraints.size(), 5U) << "its prior, and one for each floor";
  EXPECT_TRUE(test::near(plane.pose(5), Pose::Identity(), 1e-9));
  EXPECT_EQ(plane.constraints[0].first, 5);
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_EQ(plane.constraints[i].first, 5);
    EXPECT_EQ(plane.constraints[i].second, drive_.floors[i - 1].node);
  }
  EXPECT_NEAR(whole_chi2(plane), 0.0, 1e-9);
}

TEST_F(FloorFactors, AreContradictedByAHeightByTheSumOfTheirVariances) {
  for (DriveFloor& floor : drive_.floors) {
    floor.floor.covariance = Eigen::Vector3d(1e-4, 1e-4, 0.0002).asDiagonal();
  }
  drive_.nodes[1].T_map_base.translation.z() += 0.06;
  // 0.0002 + 0.0002 + 0.02^2 of two floors, 0.0002 + 0.02^2 of one and the plane.
  EXPECT_NEAR(whole_chi2(graph(FloorConstraint::kNeighbours)), 0.0036 / 0.0008, 1e-6);
  EXPECT_NEAR(whole_chi2(graph(FloorConstraint::kPlane)), 0.0036 / 0.0006, 1e-6);
}

TEST_F(FloorFactors, NeedAFloor) {
  drive_.floors.clear();
  EXPECT_EQ(graph(FloorConstraint::kPlane).states.size(), 5U);
  EXPECT_TRUE(graph(FloorConstraint::kNeighbours).constraints.empty());
}

}  // namespace
}  // namespace lidar_mapping::back_end
