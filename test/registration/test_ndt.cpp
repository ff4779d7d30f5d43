// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/registration/ndt_matcher.hpp"

#include "corner_map.hpp"
#include "ndt/ndt_kernels.hpp"
#include "near.hpp"

namespace lidar_mapping::registration {
namespace {

/// Points of the scene as a sensor at T_map_sensor sees them, moving with `twist`.
NdtPoints seen_from(const MotionState& state, const PointCloud& scene) {
  std::vector<float> x, y, z, s;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const double time = -0.05 + 0.1 * static_cast<double>(i % 100) / 99.0;
    const Vector6d step = time * state.twist;
    const Pose T = perturbed(state.T_map_sensor, step);
    const Eigen::Vector3d p = T.inverse() * scene.points[i].position().cast<double>();
    x.push_back(static_cast<float>(p.x()));
    y.push_back(static_cast<float>(p.y()));
    z.push_back(static_cast<float>(p.z()));
    s.push_back(static_cast<float>(time));
  }
  NdtPoints points;
  points.assign(x, y, z, s);
  return points;
}

const MotionBelief kWeak{{}, Matrix12d::Identity()};

TEST(NdtMatcher, FindsPoseAndTwistTogether) {
  GaussianVoxelMap map = corner_map();
  MotionState truth;
  truth.T_map_sensor = {exp_so3({0.01, -0.02, 0.1}), {0.4, -0.3, 0.05}};
  truth.twist << 5.0, 0.0, 0.0, 0.0, 0.0, 0.4;
  const NdtPoints points = seen_from(truth, test::street_corner(2, 4000, 0.01));
  const MotionBelief nothing{{}, 1e-6 * Matrix12d::Identity()};
  const NdtMatch match = NdtMatcher().match(points, map, nothing, MotionState{}, NdtOptions{});
  EXPECT_TRUE(match.converged);
  EXPECT_TRUE(test::near(match.state.T_map_sensor, truth.T_map_sensor, 0.01, 0.002));
  EXPECT_TRUE(test::near(match.state.twist.head<3>(), truth.twist.head<3>(), 0.4));
  EXPECT_TRUE(test::near(match.state.twist.tail<3>(), truth.twist.tail<3>(), 0.05));
}

// A step of less than a millimetre changes nothing: going on would cost time and bring nothing.
TEST(NdtMatcher, StopsWhereAStepNoLongerMatters) {
  GaussianVoxelMap map = corner_map();
  MotionState start;
  start.T_map_sensor = {exp_so3({0.0, 0.0, 0.02}), {0.1, -0.05, 0.02}};
  for (const unsigned seed : {2U, 3U, 4U}) {
    const NdtPoints points = seen_from(MotionState{}, test::street_corner(seed, 4000, 0.02));
    const NdtMatch match = NdtMatcher().match(points, map, kWeak, start, NdtOptions{});
    EXPECT_TRUE(match.converged);
    EXPECT_LE(match.iterations, 4) << seed << ": 5 or 6 with a tolerance a hundredth as large";
  }
}

// Without a map the prior alone says where to go.
TEST(NdtMatcher, SaysHowFarItWent) {
  GaussianVoxelMap empty(1.0, 16);
  MotionState start;
  start.T_map_sensor.translation = {3.0, -4.0, 0.0};
  const NdtPoints points = seen_from(MotionState{}, test::street_corner(2, 400, 0.02));
  const NdtMatch match = NdtMatcher().match(points, empty, kWeak, start, NdtOptions{});
  EXPECT_TRUE(test::near(match.state.T_map_sensor, Pose::Identity(), 1e-6, 1e-6));
  EXPECT_NEAR(match.excursion, 5.0, 1e-6);
  EXPECT_EQ(NdtMatcher().evaluate(points, empty, start, NdtOptions{}).excursion, 0.0);
}

// In units of what the planes claim: walls that are smoother than those of the map fit better.
TEST(NdtMatcher, ReportsTheDistanceOfThePointsFromTheirPlanes) {
  GaussianVoxelMap map = corner_map();
  const auto variance_with = [&](double noise) {
    const NdtPoints points = seen_from(MotionState{}, test::street_corner(2, 4000, noise));
    return NdtMatcher().match(points, map, kWeak, MotionState{}, NdtOptions{}).residual_variance;
  };
  const double usual = variance_with(0.02);
  EXPECT_GT(usual, 0.1);
  EXPECT_LT(usual, 1.0);
  EXPECT_LT(variance_with(0.01), 0.7 * usual);
  EXPECT_GT(variance_with(0.04), 1.6 * usual);
}

TEST(NdtMatcher, AllNeighborSearchesAgree) {
  GaussianVoxelMap map = corner_map();
  const auto pair_quality = [](const NdtMatch& fit) { return fit.quality / fit.overlap; };
  const NdtPoints points = seen_from(MotionState{}, test::street_corner(3, 4000, 0.01));
  MotionState start;
  start.T_map_sensor.translation = {0.3, 0.2, -0.1};
  const NdtMatch direct = NdtMatcher().match(points, map, kWeak, start, NdtOptions{});
  for (const auto search :
       {NeighborSearch::kDirect1, NeighborSearch::kDirect7, NeighborSearch::kKdTree}) {
    NdtOptions options;
    options.neighbor_search = search;
    const NdtMatch match = NdtMatcher().match(points, map, kWeak, start, options);
    EXPECT_TRUE(test::near(match.state.T_map_sensor.translation, Eigen::Vector3d::Zero(), 0.03));
    for (const NdtMatch& fit : {match, NdtMatcher().evaluate(points, map, match.state, options)}) {
      EXPECT_LE(fit.quality, 1.0);
      EXPECT_LE(fit.inlier_fraction, 1.0);
      EXPECT_LE(fit.overlap, 1.0);
      EXPECT_NEAR(pair_quality(fit), pair_quality(direct), 0.1);
    }
    // A point with seven planes is one measurement.
    const double information = match.information.trace() / direct.information.trace();
    EXPECT_GT(information, 0.5);
    EXPECT_LT(information, 2.0);
  }
}

/// Points on the walls and the floor of a corridor that bends around (0, radius).
PointCloud bent_corridor(unsigned seed, double radius) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> angle(-0.6, 0.6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  PointCloud cloud;
  for (int i = 0; i < 30000; ++i) {
    const double a = angle(engine);
    const double across = i % 3 == 0 ? 4.0 * uniform(engine) : (i % 2 == 0 ? 4.0 : -4.0);
    const double up = i % 3 == 0 ? -1.7 : 2.0 * uniform(engine);
    const double r = radius + across + noise(engine);
    cloud.points.push_back({static_cast<float>(r * std::sin(a)),
                            static_cast<float>(radius - r * std::cos(a)),
                            static_cast<float>(up + noise(engine)), 0.0F});
  }
  return cloud;
}

// Where the points do not say how far the sensor went, the prior does. The points say the rest: a
// sensor that went farther in a bend has turned, too.
TEST(NdtMatcher, FollowsThePriorAlongBlindDirectionsAndThePointsElsewhere) {
  constexpr double kRadius = 60.0;
  constexpr double kOn = 0.6;
  GaussianVoxelMap map(1.0, 1 << 14);
  insert(bent_corridor(1, kRadius), map);
  MotionBelief prior;
  prior.state.T_map_sensor.translation = {kOn, 0.1, 0.05};
  prior.information = 100.0 * Matrix12d::Identity();
  NdtOptions options;
  options.blind_directions = {Eigen::Vector3d::UnitX()};
  const NdtPoints points = seen_from(MotionState{}, bent_corridor(2, kRadius));
  const NdtMatch match = NdtMatcher().match(points, map, prior, prior.state, options);
  const Vector6d error =
      difference(Pose{exp_so3({0.0, 0.0, kOn / kRadius}), {kOn, 0.5 * kOn * kOn / kRadius, 0.0}},
                 match.state.T_map_sensor);
  EXPECT_LT(std::abs(error[0]), 0.02);
  EXPECT_LT(error.segment<2>(1).norm(), 0.003);
  EXPECT_LT(error.tail<3>().norm(), 5e-4);
}

TEST(NdtMatcher, SaysThatNothingFits) {
  GaussianVoxelMap empty(1.0, 64);
  const NdtPoints points = seen_from(MotionState{}, test::street_corner(3, 1000, 0.01));
  const NdtMatch match = NdtMatcher().match(points, empty, kWeak, MotionState{}, NdtOptions{});
  EXPECT_EQ(match.overlap, 0.0);
  EXPECT_EQ(match.quality, 0.0);
}

TEST(NdtMatcher, WeighsEachPointAsItDoesAllOfThem) {
  GaussianVoxelMap map = corner_map();
  PointCloud scene = test::street_corner(2, 3000, 0.02);
  for (float z = 20.0F; z < 30.0F; z += 0.1F) {  // the map has nothing there
    scene.points.push_back({0.0F, 0.0F, z, 0.0F});
  }
  const NdtPoints points = seen_from(MotionState{}, scene);
  const MotionState state{Pose{exp_so3({0.0, 0.0, 0.005}), {0.05, 0.02, 0.0}}, Vector6d::Zero()};
  NdtMatcher matcher;
  const NdtMatch fit = matcher.evaluate(points, map, state, {});
  const std::vector<float> weights = matcher.weights(points, map, state, {});
  ASSERT_EQ(weights.size(), points.padded_size());
  double sum = 0.0, paired = 0.0;
  for (const float weight : weights) {
    if (weight == kNoPlane) continue;
    EXPECT_GE(weight, 0.0F);
    EXPECT_LE(weight, 1.0F);
    sum += weight;
    ++paired;
  }
  const auto count = static_cast<double>(points.size());
  EXPECT_NEAR(sum / count, fit.quality, 1e-4);
  EXPECT_NEAR(paired / count, fit.overlap, 1e-9);
  EXPECT_LT(paired, count - 99.0);
}

struct Arrays {
  std::vector<float> x, y, z, s, nx, ny, nz, d;

  explicit Arrays(std::size_t count) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<float> coordinate(-20.0F, 20.0F);
    for (auto* array : {&x, &y, &z, &s, &nx, &ny, &nz, &d}) {
      for (std::size_t i = 0; i < count; ++i) array->push_back(coordinate(engine));
    }
    for (float& time : s) time *= 0.002F;
  }
};

SweepMotion some_motion() {
  SweepMotion motion{};
  const Eigen::Matrix3f R = exp_so3({0.1, 0.2, -0.4}).toRotationMatrix().cast<float>();
  for (int i = 0; i < 9; ++i) motion.rotation[i] = R(i / 3, i % 3);
  motion.translation[0] = 1.0F;
  motion.velocity[0] = 12.0F;
  motion.angular_velocity[2] = 0.5F;
  return motion;
}

// The same poses on machines with and without AVX2.
TEST(NdtKernels, WiderInstructionsGiveTheSameBits) {
  if (avx2_ndt_kernels() == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  constexpr std::size_t kCount = 512;
  const Arrays in(kCount);
  const SweepArrays points{in.x.data(), in.y.data(), in.z.data(), in.s.data()};
  const float* const planes[4] = {in.nx.data(), in.ny.data(), in.nz.data(), in.d.data()};
  const SweepMotion motion = some_motion();
  NdtSums sums[2];
  std::vector<float> q[2][3];
  std::vector<std::int32_t> cells[2];
  for (const int k : {0, 1}) {
    const NdtKernels& kernels = k == 0 ? portable_ndt_kernels() : *avx2_ndt_kernels();
    for (auto& array : q[k]) array.resize(kCount);
    cells[k].resize(kCount);
    kernels.locate(motion, 1.0F, points, kCount, q[k][0].data(), q[k][1].data(), q[k][2].data(),
                   cells[k].data());
    kernels.accumulate(q[k][0].data(), q[k][1].data(), q[k][2].data(), planes, motion.translation,
                       1e4F, kCount, &sums[k]);
  }
  EXPECT_EQ(cells[0], cells[1]);
  for (const int axis : {0, 1, 2}) EXPECT_EQ(q[0][axis], q[1][axis]);
  for (int i = 0; i < 21; ++i) EXPECT_EQ(sums[0].hessian[i], sums[1].hessian[i]) << i;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(sums[0].gradient[i], sums[1].gradient[i]) << i;
}

// The gradient of half the squared residual, against central differences.
TEST(NdtKernels, GradientAgreesWithNumericalDerivatives) {
  const Eigen::Vector3d p(7.0, -4.0, 2.0);
  const Eigen::Vector3d normal(0.3, 0.5, -0.2);
  const double offset = 1.3;
  const Pose T{exp_so3({0.1, 0.2, -0.4}), {1.0, 2.0, 3.0}};
  const auto residual = [&](const Vector6d& d) {
    const Eigen::Vector3d x = exp_so3(d.tail<3>()) * (T.rotation * p) + T.translation + d.head<3>();
    return normal.dot(x) - offset;
  };
  std::vector<float> q[3], planes[4];
  const Eigen::Vector3d rotated = T.rotation * p;
  for (int lane = 0; lane < static_cast<int>(kNdtLanes); ++lane) {
    for (int axis = 0; axis < 3; ++axis) {
      q[axis].push_back(static_cast<float>(rotated[axis]));
      planes[axis].push_back(lane == 0 ? static_cast<float>(normal[axis]) : 0.0F);
    }
    planes[3].push_back(static_cast<float>(offset));
  }
  const float* const arrays[4] = {planes[0].data(), planes[1].data(), planes[2].data(),
                                  planes[3].data()};
  const float translation[3] = {1.0F, 2.0F, 3.0F};
  NdtSums sums{};
  portable_ndt_kernels().accumulate(q[0].data(), q[1].data(), q[2].data(), arrays, translation,
                                    1e9F, kNdtLanes, &sums);
  for (int axis = 0; axis < 6; ++axis) {
    Vector6d d = Vector6d::Zero();
    d[axis] = 1e-5;
    const double numerical = (std::pow(residual(d), 2) - std::pow(residual(-d), 2)) / (4.0 * 1e-5);
    EXPECT_NEAR(sums.gradient[axis], numerical, 1e-4 * (1.0 + std::abs(numerical))) << axis;
  }
}

// Each point is in one part, and each part of the corner has points.
TEST(NdtMatcher, PartsOfAMatchAddUpToTheWhole) {
  GaussianVoxelMap map = corner_map();
  const MotionState state{Pose{exp_so3({0.0, 0.0, 0.1}), {0.05, 0.02, 0.0}}, Vector6d::Zero()};
  const NdtPoints points = seen_from(state, test::street_corner(2, 3000, 0.02));
  NdtOptions options;
  NdtMatcher matcher;
  EXPECT_TRUE(matcher.match(points, map, {}, state, options).parts.empty());
  options.parts = true;
  const NdtMatch match = matcher.match(points, map, {}, state, options);
  ASSERT_TRUE(match.converged);
  ASSERT_EQ(match.parts.size(), kNdtParts);
  Matrix6d sum = Matrix6d::Zero();
  for (const NdtPart& part : match.parts) sum += part.hessian;
  EXPECT_TRUE(test::near(sum, match.pose_hessian, 1e-4 * match.pose_hessian.norm()));
  const auto is_empty = [](const NdtPart& part) { return part.hessian.isZero(0.0); };
  EXPECT_LT(std::count_if(match.parts.begin(), match.parts.end(), is_empty), 6);
}

// With one plane for each point, and with up to seven.
TEST(NdtMatcher, SlicesOfAMatchAddUpToTheWhole) {
  GaussianVoxelMap map = corner_map();
  const MotionState state{Pose{exp_so3({0.0, 0.0, 0.1}), {0.05, 0.02, 0.0}}, Vector6d::Zero()};
  const NdtPoints points = seen_from(state, test::street_corner(2, 3000, 0.02));
  for (const NeighborSearch search : {NeighborSearch::kDirect1, NeighborSearch::kDirect7}) {
    NdtOptions options;
    options.neighbor_search = search;
    NdtMatcher matcher;
    EXPECT_TRUE(matcher.match(points, map, {}, state, options).slices.empty());
    options.parts = true;
    const NdtMatch match = matcher.match(points, map, {}, state, options);
    ASSERT_EQ(match.slices.size(), points.slices().size());
    Matrix6d sum = Matrix6d::Zero();
    double last = -1.0;
    for (const NdtSlice& slice : match.slices) {
      EXPECT_GT(slice.time, last);
      last = slice.time;
      sum += slice.part.hessian;
    }
    EXPECT_TRUE(test::near(sum, match.pose_hessian, 1e-9 * match.pose_hessian.norm()));
  }
}

}  // namespace
}  // namespace lidar_mapping::registration
