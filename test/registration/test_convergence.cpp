// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "lidar_mapping/common/units.hpp"

#include "method_test.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

constexpr std::array<double, 6> kDistances = {0.0, 0.5, 1.0, 2.0, 5.0, 10.0};  // m
constexpr std::array<double, 4> kAngles = {0.0, 6.0, 15.0, 30.0};              // deg

enum class Outcome { kFound, kRefused, kWrong };

/// What becomes of a start; wrong is what looks like a success and is none.
Outcome outcome_of(const RegistrationResult& result, const Pose& truth) {
  const bool looks_good = result.converged && result.inlier_fraction > 0.9;
  const bool is_good = distance_between(result.T_target_source, truth) < 0.15 &&
                       angle_between(result.T_target_source, truth) < 0.02;
  if (is_good) return Outcome::kFound;
  return looks_good ? Outcome::kWrong : Outcome::kRefused;
}

/// Distance from which a method must find the truth, turned by up to 6 degrees besides.
double sure_distance(Method method) { return method == Method::kNdt ? 2.0 : 0.5; }

class Convergence : public MethodTest {};

// The basin of convergence is known, and outside of it nothing is called a success.
TEST_P(Convergence, SucceedsNearbyAndSaysSoElsewhere) {
  Scene scene = make_scene(0.02);
  scene.source.points.resize(1500);
  const auto registration = make_registration(config());
  registration->set_target(scene.target);
  std::string map;
  for (const double angle : kAngles) {
    for (const double distance : kDistances) {
      const double heading = 0.7 + distance;
      const Pose start = scene.T_target_source * pose_of(distance * std::cos(heading),
                                                         distance * std::sin(heading), 0.0, 0.0,
                                                         0.0, angle * kRadPerDeg);
      const Outcome outcome =
          outcome_of(registration->align(scene.source, start), scene.T_target_source);
      map += "+.!"[static_cast<int>(outcome)];
      EXPECT_NE(outcome, Outcome::kWrong) << distance << " m, " << angle << " deg";
      if (distance <= sure_distance(GetParam()) && angle <= 6.0) {
        EXPECT_EQ(outcome, Outcome::kFound) << distance << " m, " << angle << " deg";
      }
    }
    map += ' ';
  }
  RecordProperty("map", map);  // a word per angle; + found, . refused
}

INSTANTIATE_TEST_SUITE_P(All, Convergence, testing::ValuesIn(kAllMethods), method_name);

// 1 cm, not the root of it: no step is longer than 0.1 m, so the first one would be the last.
TEST(PclNdt, TakesTheEpsilonOfLidarLocalizationAsALength) {
  const Scene scene = make_scene(0.05);
  RegistrationConfig config;
  config.method = Method::kPclNdt;
  config.transformation_epsilon = 0.01;
  config.rotation_epsilon = M_PI;
  const auto registration = make_registration(config);
  registration->set_target(scene.target);
  const RegistrationResult result =
      registration->align(scene.source, scene.T_target_source * pose_of(0.5, 0, 0, 0, 0, 0));
  EXPECT_GT(result.iterations, 3);
  EXPECT_TRUE(
      test::near(result.T_target_source.translation, scene.T_target_source.translation, 0.1));
}

}  // namespace
}  // namespace lidar_mapping::registration
