// SPDX-License-Identifier: BSD-3-Clause
// 207 m of a city street with a sharp bend, recorded at about five scans a second, as it is and as
// other sensors and other weather would have recorded it.

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

#include "judgement/step_belief.hpp"
#include "recorded_scans.hpp"
#include "test_data.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr double kPeriod = 0.207;  // s, mean of the recording

using Engine = std::mt19937;
/// Makes of a recorded scan one of another sensor.
using Disturbance = std::function<PointCloud(const PointCloud&, Engine&)>;

PointCloud as_it_is(const PointCloud& cloud, Engine&) { return cloud; }

/// Drops of rain or flakes of snow stop a fraction of the rays before they hit a surface.
Disturbance rain(double fraction) {
  return [fraction](PointCloud cloud, Engine& engine) {
    std::bernoulli_distribution hit(fraction);
    std::uniform_real_distribution<float> part(0.05F, 1.0F);
    for (Point& point : cloud.points) {
      if (!hit(engine)) continue;
      const float scale = part(engine);
      point.x *= scale;
      point.y *= scale;
      point.z *= scale;
    }
    return cloud;
  };
}

Disturbance only(const std::function<bool(const Point&)>& is_kept) {
  return [is_kept](const PointCloud& cloud, Engine&) {
    PointCloud kept;
    for (const Point& point : cloud.points) {
      if (is_kept(point)) kept.points.push_back(point);
    }
    return kept;
  };
}

bool is_ahead(const Point& point) { return point.x > std::abs(point.y); }

/// One in four of the rings of this sensor: a third of a degree apart above -8.5 degrees, half a
/// degree below.
bool is_one_ring_in_four(const Point& point) {
  const double elevation = std::atan2(point.z, std::hypot(point.x, point.y)) * 180.0 / M_PI;
  const double ring = elevation > -8.58 ? (2.0 - elevation) * 3.0 : 32.0 - (8.83 + elevation) * 2.0;
  return std::lround(ring) % 4 == 0;
}

/// 20 degrees about a slanting axis.
Pose askew() {
  const Eigen::AngleAxisd rotation(0.35, Eigen::Vector3d(0.3, 1.0, 0.5).normalized());
  return {Eigen::Quaterniond(rotation), Eigen::Vector3d::Zero()};
}

struct Variant {
  const char* name;
  Disturbance disturbance;
  std::size_t every;
  double drift_percent;  ///< that is allowed; the reference itself is good to some tenths
  Pose T_base_lidar = {};
};

class RecordedDrive : public testing::TestWithParam<Variant> {};

TEST_P(RecordedDrive, IsTrackedToItsEnd) {
  REQUIRE_RECORDED(folder, "kitti00_scans");
  const auto truth = test::recorded_poses(folder);
  FrontEnd front_end{FrontEndConfig{}};
  const Pose& T_base_lidar = GetParam().T_base_lidar;
  Engine engine(1);
  std::vector<evaluation::PosePair> pairs;
  for (std::size_t i = 0; i < truth.size(); i += GetParam().every) {
    const Stamp stamp = from_seconds(1.0 + kPeriod * static_cast<double>(i));
    const PointCloud cloud = GetParam().disturbance(test::recorded_scan(folder, i), engine);
    const FrontEndResult result = front_end.process({stamp, transformed(cloud, T_base_lidar)});
    EXPECT_NE(result.status.state, TrackingState::kLost) << i;
    pairs.push_back({stamp, T_base_lidar * truth[i] * T_base_lidar.inverse(), result.T_odom_base});
  }
  const auto errors = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  EXPECT_LT(errors.translation_percent, GetParam().drift_percent);
}

INSTANTIATE_TEST_SUITE_P(City, RecordedDrive,
                         testing::Values(Variant{"AsItIs", as_it_is, 1, 0.7},
                                         Variant{"EverySecondScan", as_it_is, 2, 0.8},
                                         Variant{"Rain", rain(0.1), 1, 1.2},
                                         Variant{"HeavyRain", rain(0.3), 1, 2.0},
                                         Variant{"SectorAhead", only(is_ahead), 1, 1.4},
                                         Variant{"SixteenRings", only(is_one_ring_in_four), 1, 1.2},
                                         Variant{"MountedAskew", as_it_is, 1, 0.8, askew()}),
                         [](const auto& variant) { return variant.param.name; });

// A scan every 0.83 s, 5.4 m apart in the mean.
TEST(ThinnedRecording, EveryWrongStepIsReported) {
  REQUIRE_RECORDED(folder, "kitti00_scans");
  const auto truth = test::recorded_poses(folder);
  FrontEnd front_end{FrontEndConfig{}};
  Pose T_map_last, T_odom_last;
  int wrong = 0;
  int silent = 0;
  for (std::size_t i = 0; i < truth.size(); i += 4) {
    const Stamp stamp = from_seconds(1.0 + kPeriod * static_cast<double>(i));
    const FrontEndResult result = front_end.process({stamp, test::recorded_scan(folder, i)});
    const TrackingState state = result.status.state;
    const Pose error =
        (T_map_last.inverse() * truth[i]).inverse() * (T_odom_last.inverse() * result.T_odom_base);
    const bool is_wrong = i > 0 && (error.translation.norm() > kWrongStep ||
                                    rotation_angle(error.rotation) > kWrongStepAngle);
    wrong += is_wrong ? 1 : 0;
    silent += is_wrong && state == TrackingState::kTracking ? 1 : 0;
    if (!claims_pose(state)) continue;
    T_map_last = truth[i];
    T_odom_last = result.T_odom_base;
  }
  RecordProperty("wrong", wrong);
  EXPECT_EQ(silent, 0) << "of " << wrong << " wrong steps";
}

}  // namespace
}  // namespace lidar_mapping::front_end
