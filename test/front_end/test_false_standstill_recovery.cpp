// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "near.hpp"
#include "sampled_points.hpp"
#include "start/false_standstill_recovery.hpp"

namespace lidar_mapping::front_end {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Points up a pole.
void add_pole(float x, float y, Points& points) {
  for (float z = -1.5F; z < 1.0F; z += 0.25F) points.emplace_back(x, y, z);
}

/// Rings on the ground, which go with the sensor.
void add_rings(Points& points) {
  for (const float radius : {6.0F, 8.0F, 12.0F, 25.0F}) {
    for (float angle = 0.0F; angle < 6.28F; angle += 0.02F) {
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), -1.8F);
    }
  }
}

/// A field with a few poles.
Points field(unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> place(-40.0F, 40.0F);
  Points poles;
  for (int i = 0; i < 12; ++i) add_pole(place(engine), place(engine), poles);
  return poles;
}

/// The side of a truck.
Points truck(double x) {
  Points points;
  for (float along = -3.0F; along < 3.0F; along += 0.3F) {
    for (float z = -1.0F; z < 1.0F; z += 0.5F) {
      points.emplace_back(static_cast<float>(x) + along, 3.0F, z);
    }
  }
  return points;
}

/// What the sensor sees from there, rings included.
SampledPoints measured_from(const Points& world, const Pose& T_map_sensor) {
  const Pose T_sensor_map = T_map_sensor.inverse();
  Points points;
  add_rings(points);
  for (const Eigen::Vector3f& p : world) {
    points.push_back((T_sensor_map * p.cast<double>()).cast<float>());
  }
  return sampled(points);
}

Pose ahead(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}; }

/// A sensor whose matches stay at one pose.
class StationaryMatches {
 public:
  explicit StationaryMatches(const Points& world, const Pose& matched = Pose{})
      : matched_pose_(matched) {
    filter_.reset(Pose{}, 0.1, 0.1);
    false_standstill_.insert(measured_from(world, Pose{}), {Pose{}, Vector6d::Zero()});
  }

  /// True once a motion was detected; then filter() has the new pose.
  bool process(const SampledPoints& points) {
    MotionFilter high_noise = filter_.with_high_process_noise();
    for (MotionFilter* filter : {&filter_, &high_noise}) filter->predict(0.1);
    registration::NdtMatch match;
    match.overlap = 0.3;
    match.state.T_map_sensor = matched_pose_;
    std::optional<MotionFilter> recovered =
        false_standstill_.track(points, high_noise, filter_.state().T_map_sensor);
    if (!recovered) recovered = false_standstill_.detect(points, match, 0.1, true, filter_);
    if (recovered) {
      filter_ = *recovered;
    } else {
      filter_.restart({matched_pose_, Vector6d::Zero()}, 1e-4 * Matrix12d::Identity());
    }
    return recovered.has_value();
  }

  const MotionFilter& filter() const { return filter_; }

 private:
  Pose matched_pose_;
  MotionFilter filter_{10.0, 5.0};
  FalseStandstillRecovery false_standstill_;
};

TEST(VerticalStructurePoints, AreAboveTheGround) {
  Points points;
  for (float x = -5.0F; x < 5.0F; x += 0.2F) {
    for (float y = -5.0F; y < 5.0F; y += 0.2F) points.emplace_back(x, y, 0.3F * x);
  }
  EXPECT_TRUE(vertical_structure_points(sampled(points)).empty());
  for (float z = 0.3F; z < 3.0F; z += 0.25F) points.emplace_back(0.5F, 0.5F, z);
  const Points vertical = vertical_structure_points(sampled(points));
  EXPECT_GE(vertical.size(), 8U);
  for (const Eigen::Vector3f& p : vertical) EXPECT_EQ(p.x(), 0.5F);
}

TEST(VerticalStructureMap, FindsThePoseWhereThePointsFit) {
  const Points world = vertical_structure_points(measured_from(field(1), Pose{}));
  VerticalStructureMap map;
  map.insert(world, Pose{});
  Vector6d d = Vector6d::Zero();
  d[0] = 0.25;
  d[1] = -0.1;
  d[5] = 0.004;
  const VerticalStructureMap::Fit fit = map.fit(world, perturbed(Pose{}, d));
  EXPECT_TRUE(test::near(fit.T_map_sensor, Pose{}, 0.02));
  EXPECT_GT(fit.evidence, map.evaluate(world, perturbed(Pose{}, d)).evidence);
  EXPECT_EQ(fit.matched_points, world.size());
  EXPECT_EQ(map.count_near(world, Pose{}), world.size());
  EXPECT_LT(map.count_near(world, ahead(5.0)), world.size() / 10) << "filters err now and then";
}

/// Whether a motion is detected while the matches stay at this pose.
bool is_detected_from(const Pose& matched) {
  const Points world = field(1);
  StationaryMatches stationary(world, matched);
  bool found = false;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.01 * i * i;
    found |= stationary.process(measured_from(world, ahead(x)));
  }
  return found;
}

// A drone that climbs or tilts sees other rings.
TEST(FalseStandstillRecovery, IsOnlyOfALevelSensorAtTheSameHeight) {
  EXPECT_TRUE(is_detected_from({Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.1}}));
  EXPECT_FALSE(is_detected_from({Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.5}}));
  EXPECT_TRUE(is_detected_from({exp_so3({0.0, 0.02, 0.0}), Eigen::Vector3d::Zero()}));
  EXPECT_FALSE(is_detected_from({exp_so3({0.0, 0.08, 0.0}), Eigen::Vector3d::Zero()}));
}

TEST(FalseStandstillRecovery, DetectsAndTracksTheMotion) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Points world = field(seed);
    StationaryMatches stationary(world);
    bool found = false;
    for (int i = 0; i < 40; ++i) {
      const double x = 0.5 * 2.0 * (0.1 * i) * (0.1 * i);
      found = stationary.process(measured_from(world, ahead(x)));
      if (!found) continue;
      EXPECT_TRUE(test::near(stationary.filter().state().T_map_sensor.translation,
                             ahead(x).translation, 0.3))
          << seed << " " << i;
    }
    EXPECT_TRUE(found) << seed;
  }
}

TEST(FalseStandstillRecovery, EndsWithoutVerticalStructures) {
  const Points world = field(1);
  StationaryMatches stationary(world);
  bool found = false;
  for (int i = 0; i < 40 && !found; ++i)
    found = stationary.process(measured_from(world, ahead(0.01 * i * i)));
  ASSERT_TRUE(found);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(stationary.process(measured_from({}, ahead(10.0)))) << i;
  for (int i = 0; i < 10; ++i) found = stationary.process(measured_from({}, ahead(10.0)));
  EXPECT_FALSE(found);
}

// It fits as well farther ahead and behind.
TEST(FalseStandstillRecovery, IgnoresAWallAlongThePath) {
  Points wall;
  for (float x = -40.0F; x < 40.0F; x += 0.5F) add_pole(x, 6.0F, wall);
  StationaryMatches stationary(wall, {Eigen::Quaterniond::Identity(), {0.0, 0.8, 0.0}});
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(stationary.process(measured_from(wall, Pose{}))) << i;
}

TEST(FalseStandstillRecovery, IgnoresAPassingTruck) {
  const Points poles = field(4);
  Points first = poles;
  for (const Eigen::Vector3f& p : truck(-8.0)) first.push_back(p);
  StationaryMatches stationary(first);
  for (int i = 0; i < 60; ++i) {
    Points world = poles;
    for (const Eigen::Vector3f& p : truck(-8.0 + 0.3 * i)) world.push_back(p);
    EXPECT_FALSE(stationary.process(measured_from(world, Pose{}))) << i;
  }
}

// More of what stands upright goes than stays, but not by more than chance may make it.
TEST(FalseStandstillRecovery, IgnoresPedestriansThatWalkTogether) {
  const auto around = [](double walked) {
    Points world;
    for (const auto& [x, y] : {std::pair{8.0F, 1.0F}, {1.0F, -9.0F}, {-12.0F, -3.0F}}) {
      add_pole(x, y, world);
    }
    for (const auto& [x, y] : {std::pair{9.0F, 6.0F}, {2.0F, 7.0F}, {-6.0F, 5.0F}, {7.0F, -6.0F}}) {
      add_pole(x - static_cast<float>(walked), y, world);
    }
    return world;
  };
  StationaryMatches stationary(around(0.0));
  for (int i = 0; i < 30; ++i)
    EXPECT_FALSE(stationary.process(measured_from(around(0.14 * i), Pose{}))) << i;
}

}  // namespace
}  // namespace lidar_mapping::front_end
