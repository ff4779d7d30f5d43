// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/config/load.hpp"

#include "decision/decision.hpp"
#include "drive.hpp"
#include "matching/scan_alignment.hpp"
#include "matching/submap_builder.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

TEST(Matching, ARoofIsALevelSurfaceOverhead) {
  const auto roofed = [](const ToyWorld& world) {
    const auto truth = along({{-20, 0}, {20, 0}});
    DriveClouds clouds(world, truth);
    Trajectory trajectory;
    for (std::size_t i = 0; i < truth.size(); ++i) trajectory.append(key_frame(i, truth[i]));
    SubmapBuilder submaps({}, clouds);
    submaps.set_sensor_origin(ToyWorld::sensor());
    return roofed_fraction(*submaps.around(trajectory, truth.size() / 2));
  };
  ToyWorld world = make_town(60.0, 100.0, 3);
  EXPECT_LT(roofed(world), 0.1);
  world.floors.push_back(3.5);
  EXPECT_GT(roofed(world), 0.3);
}

/// A street with a submap around its middle and a scan from another pose in it.
struct Street {
  explicit Street(const ToyWorld& world, const Pose& newest)
      : poses(along({{-30, 0}, {30, 0}})), clouds(world, with(poses, newest)), submaps({}, clouds) {
    submaps.set_sensor_origin(ToyWorld::sensor());
    for (std::size_t i = 0; i < poses.size(); ++i) trajectory.append(key_frame(i, poses[i]));
    submap = submaps.around(trajectory, kMiddle);
    KeyFrame last = key_frame(poses.size(), newest);
    last.segment = 1;
    trajectory.append(last);
    submaps.add_newest(last);
    query = submaps.query(trajectory);
    T_true = poses[kMiddle].inverse() * newest;
  }
  static std::vector<Pose> with(std::vector<Pose> poses, const Pose& newest) {
    poses.push_back(newest);
    return poses;
  }
  Match matched(const Pose& guess) const {
    Match match;
    match.alignment = align_point_to_plane(query->points, submap->surface, guess);
    match.figures = measure_match(*query, *submap, match.alignment.T_target_source, 2.0);
    return match;
  }

  static constexpr std::size_t kMiddle = 15;
  std::vector<Pose> poses;
  DriveClouds clouds;
  Trajectory trajectory;
  SubmapBuilder submaps;
  std::shared_ptr<const Submap> submap;
  std::optional<QueryScan> query;
  Pose T_true;
};

/// Standard deviation of the height (m) of a scan of a floor and two walls. Its floor is 5 cm too
/// high or too low, from one square of `square` half metres to the next.
double height_stddev(int square) {
  std::vector<Eigen::Vector3f> target, source;
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) {
      const Eigen::Vector2f p(0.5F * static_cast<float>(x) + 0.1F,
                              0.5F * static_cast<float>(y) + 0.1F);
      const float offset = (x / square + y / square) % 2 == 0 ? 0.05F : -0.05F;
      for (const Eigen::Vector3f& wall : {Eigen::Vector3f(0.0F, p.x(), p.y() + 1.0F),
                                          Eigen::Vector3f(p.x(), 0.0F, p.y() + 1.0F)}) {
        target.push_back(wall);
        source.push_back(wall);
      }
      target.emplace_back(p.x(), p.y(), 0.5F);
      source.emplace_back(p.x(), p.y(), 0.5F + offset);
    }
  }
  const auto covariance = point_to_plane_covariance(source, SurfaceCloud(target), Pose());
  return std::sqrt(covariance.value()(2, 2));
}

// Errors of single points average out, errors of whole surfaces do not.
TEST(Covariance, IsLargerIfWholeSurfacesAreDisplaced) {
  EXPECT_GT(height_stddev(4), 2.0 * height_stddev(1));
}

Prior anything() { return {}; }

TEST(Matching, ConvergesFromTheStartingPoseByAppearance) {
  const Street street(make_town(100.0, 100.0, 6), planar(2.0, 3.0, kPi));
  for (const double x : {-1.5, 0.0, 1.5}) {
    for (const double turn : {-0.08, 0.08}) {
      const Match match = street.matched(street.T_true * planar(x, 1.0, turn));
      EXPECT_TRUE(match.alignment.converged);
      EXPECT_TRUE(near(match.alignment.T_target_source, street.T_true, 0.05, 0.005));
      EXPECT_EQ(decide(match, anything(), {}).verdict, Verdict::kAccepted);
    }
  }
}

class MatchingBy : public testing::TestWithParam<LoopMethod> {};

TEST_P(MatchingBy, FindsTheTruePoseWithTheSameCovariance) {
  const Street street(make_town(100.0, 100.0, 6), planar(1.0, 1.0, 0.2));
  const Pose guess = street.T_true * planar(0.2, -0.15, 0.02);
  LoopClosingConfig config;
  config.registration_method = GetParam();
  ScanAlignment alignment(config);
  Match match;
  match.alignment = alignment.align(street.query->points, street.submap->surface, guess);
  EXPECT_TRUE(match.alignment.converged);
  EXPECT_TRUE(near(match.alignment.T_target_source, street.T_true, 0.1, 0.01));
  EXPECT_TRUE(is_valid_covariance(match.alignment.covariance));
  EXPECT_LT(match.alignment.covariance(0, 0), 0.01 * 0.01);
  match.figures =
      measure_match(*street.query, *street.submap, match.alignment.T_target_source, 2.0);
  EXPECT_EQ(decide(match, anything(), config).verdict, Verdict::kAccepted);
}

TEST_P(MatchingBy, DoesNotConvergeWithoutNearPoints) {
  const Street street(make_town(100.0, 100.0, 6), planar(1.0, 1.0, 0.2));
  LoopClosingConfig config;
  config.registration_method = GetParam();
  ScanAlignment alignment(config);
  const Pose far_start = street.T_true * planar(500.0, 0.0, 0.0);
  EXPECT_FALSE(alignment.align(street.query->points, street.submap->surface, far_start).converged);
}

using registration::Method;
INSTANTIATE_TEST_SUITE_P(All, MatchingBy,
                         testing::Values(LoopMethod{}, LoopMethod{false, Method::kNdt},
                                         LoopMethod{false, Method::kVgicp},
                                         LoopMethod{false, Method::kPclNdt},
                                         LoopMethod{false, Method::kIcp},
                                         LoopMethod{false, Method::kGicp}),
                         [](const auto& instance) {
                           return instance.param.point_to_plane
                                      ? std::string("POINT_TO_PLANE")
                                      : registration::to_string(instance.param.other);
                         });

TEST(Matching, UsesTheConfiguredMethod) {
  const auto load = [](const std::string& text) {
    return config::load<LoopClosingConfig>({config::parse_yaml(text, "loop_closing.yaml")});
  };
  EXPECT_TRUE(load("").registration_method.point_to_plane);
  const LoopClosingConfig config =
      load("registration_method: FAST_GICP\nreg_resolution: 0.5\nreg_maximum_iterations: 30\n");
  EXPECT_EQ(config.registration_method, (LoopMethod{false, Method::kFastGicp}));
  EXPECT_EQ(config.registration.resolution, 0.5);
  EXPECT_EQ(config.registration.max_iterations, 30);
  EXPECT_NE(config::to_yaml(config).find("registration_method: FAST_GICP"), std::string::npos);
  EXPECT_THROW(load("registration_method: FOO\n"), ConfigError);
}

TEST(Matching, CovarianceMatchesTheErrors) {
  const Street street(make_town(100.0, 100.0, 6), planar(1.0, 1.0, 0.2));
  const Match match = street.matched(street.T_true);
  EXPECT_TRUE(is_valid_covariance(match.alignment.covariance));
  EXPECT_LT(match.alignment.covariance(0, 0), 0.01 * 0.01);
}

/// The scan is moved by a metre: with this range all of its points count, or only the near ones.
TEST(Matching, PointsBeyondTheMaximumRangeDoNotCountInTheFitness) {
  const Street street(make_town(100.0, 100.0, 6), planar(1.0, 1.0, 0.2));
  const Pose moved = street.T_true * planar(0.7, 0.7, 0.0);
  const auto fitness = [&](double range) {
    return measure_match(*street.query, *street.submap, moved, range).fitness;
  };
  EXPECT_LE(fitness(0.3), 0.3 * 0.3);
  EXPECT_LE(fitness(0.8), 0.8 * 0.8);
  EXPECT_GT(fitness(0.8), fitness(0.3));
  EXPECT_GT(fitness(3.0), fitness(0.8));
}

// The fitness at a wrong location can be small; overlap and free space are not.
TEST(Matching, AnotherLocationIsRefused) {
  const ToyWorld here = make_town(100.0, 100.0, 6);
  const ToyWorld elsewhere = make_town(100.0, 100.0, 7);
  Street street(here, planar(0.0, 0.0, 0.0));
  DriveClouds other(elsewhere, {planar(0.0, 0.0, 0.0)});
  SubmapBuilder submaps({}, other);
  Trajectory trajectory;
  KeyFrame key = key_frame(0, planar(0.0, 0.0, 0.0));
  trajectory.append(key);
  submaps.add_newest(key);
  street.query = submaps.query(trajectory);
  int accepted = 0;
  for (double heading = 0.0; heading < 2.0 * kPi; heading += kPi / 6.0) {
    const Match match = street.matched(planar(0.0, 0.0, heading));
    accepted += decide(match, anything(), {}).verdict == Verdict::kAccepted;
  }
  EXPECT_EQ(accepted, 0);
}

/// A smooth tunnel along x, 8 m wide and 5 m high.
ToyWorld make_tunnel() {
  ToyWorld world;
  world.boxes = {
      {{-200, 4, 0}, {200, 6, 5}}, {{-200, -6, 0}, {200, -4, 5}}, {{-200, -6, 5}, {200, 6, 6}}};
  return world;
}

// A tunnel looks the same everywhere along its axis.
TEST(Matching, ATunnelDoesNotDetermineThePosition) {
  const Street street(make_tunnel(), planar(0.5, 0.0, 0.0));
  for (const double slip : {-6.0, -3.0, 3.0, 6.0}) {
    const Match match = street.matched(street.T_true * planar(slip, 0.3, 0.02));
    EXPECT_LT(match.figures.horizontal_eigenvalue, 0.02);
    EXPECT_NE(decide(match, anything(), {}).verdict, Verdict::kAccepted);
  }
}

TEST(Matching, AnOpenFieldStaysUndecided) {
  const Street street(ToyWorld(), planar(1.0, 0.0, 0.0));
  const Match match = street.matched(street.T_true);
  const Decision decision = decide(match, anything(), {});
  EXPECT_NE(decision.verdict, Verdict::kAccepted);
}

TEST(Matching, ObjectsInObservedFreeSpaceViolateIt) {
  ToyWorld before = make_town(100.0, 100.0, 6);
  ToyWorld after = before;
  for (double x = -20.0; x < 20.0; x += 6.0) after.boxes.push_back({{x, 4, 0}, {x + 4, 5.5, 2.5}});
  const Street same(before, planar(0.0, 0.0, 0.0));
  Street changed(before, planar(0.0, 0.0, 0.0));
  DriveClouds clouds(after, {planar(0.0, 0.0, 0.0)});
  SubmapBuilder submaps({}, clouds);
  submaps.set_sensor_origin(ToyWorld::sensor());
  Trajectory trajectory;
  trajectory.append(key_frame(0, planar(0.0, 0.0, 0.0)));
  submaps.add_newest(key_frame(0, planar(0.0, 0.0, 0.0)));
  changed.query = submaps.query(trajectory);
  EXPECT_LT(same.matched(same.T_true).figures.free_space_violation, 0.02);
  EXPECT_GT(changed.matched(changed.T_true).figures.free_space_violation, 0.1);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
