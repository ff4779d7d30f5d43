// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

#include "near.hpp"

namespace lidar_mapping::simulation {
namespace {

const std::string kReverse = "_reverse";  // at the end of the name of a drive

bool is_reverse(const std::string& name) { return name.find(kReverse) != std::string::npos; }

/// Drives, each built once for all tests, because building a world takes a second.
const Drive& drive_of(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Drive>> built;
  std::unique_ptr<Drive>& drive = built[name];
  if (!drive) {
    DriveOptions options;
    options.drive = name.substr(0, name.find(kReverse));
    options.reverse = is_reverse(name);
    options.rounds = 1;
    drive = std::make_unique<Drive>(options);
  }
  return *drive;
}

std::vector<Pose> poses_every(const Drive& drive, double seconds) {
  std::vector<Pose> poses;
  const SmoothTrajectory& trajectory = drive.trajectory();
  for (Stamp t = trajectory.begin(); t <= trajectory.end(); t += from_seconds(seconds)) {
    poses.push_back(trajectory.pose(t));
  }
  return poses;
}

/// Limits of the motion of a carrier.
struct Limits {
  double speed, acceleration, rate, sideways;
};
const std::map<std::string, Limits> kCarriers = {{"walk", {2.0, 5.0, 2.0, 1.0}},
                                                 {"handheld", {3.0, 9.0, 4.5, 1.5}},
                                                 {"handheld_forest", {3.0, 9.0, 4.5, 1.5}},
                                                 {"running", {6.0, 25.0, 6.0, 3.0}},
                                                 {"running_forest", {6.0, 25.0, 6.0, 3.0}},
                                                 {"spin", {4.0, 16.0, 7.0, 3.0}},
                                                 {"stairs", {3.0, 9.0, 4.5, 1.5}},
                                                 {"legged", {3.0, 50.0, 4.5, 1.5}},
                                                 {"legged_forest", {3.0, 50.0, 4.5, 1.5}},
                                                 {"drone", {9.0, 12.0, 6.0, 9.0}},
                                                 {"elevator", {3.0, 9.0, 4.5, 1.5}}};
const Limits kCar{18.0, 5.5, 1.0, 0.12};

class EveryDrive : public testing::TestWithParam<std::string> {
 protected:
  const Drive& drive = drive_of(GetParam());
  const bool is_car = kCarriers.count(GetParam()) == 0;
};

class EveryCar : public EveryDrive {};
/// All drives except the one in an elevator, whose car moves around the carrier.
class EveryDriveOutside : public EveryDrive {};

/// Also those that are driven in reverse.
std::vector<std::string> all_drives() {
  std::vector<std::string> names = drive_names();
  for (const char* name : {"town", "figure_eight", "open_road", "car_park", "twins", "city"}) {
    names.push_back(name + kReverse);
  }
  return names;
}

std::vector<std::string> names_where(bool (*is_wanted)(const std::string& name)) {
  std::vector<std::string> names;
  for (const std::string& name : all_drives()) {
    if (is_wanted(name)) names.push_back(name);
  }
  return names;
}

/// Rays from the middle of the vehicle to its outline must not hit anything.
TEST_P(EveryDrive, HitsNothingStatic) {
  const RayCaster caster(drive.world());
  const double half_length = is_car ? 1.9 : 0.2, half_width = is_car ? 0.85 : 0.2;
  const Eigen::Vector3d middle(is_car ? 1.3 : 0.0, 0.0, is_car ? 0.6 : 0.0);
  std::vector<Ray> rays;
  for (const Pose& pose : poses_every(drive, 0.25)) {
    for (double angle = 0.0; angle < 2.0 * M_PI; angle += M_PI / 8.0) {
      const Eigen::Vector3d to(half_length * std::cos(angle), half_width * std::sin(angle), 0.0);
      rays.push_back({(pose * middle).cast<float>(), (pose.rotation * to).cast<float>(), 0.0F});
    }
  }
  std::vector<Hit> hits;
  caster.cast(rays, 1e6, 1e6 + 1.0, 0.0F, 1.0F, hits);
  const auto met =
      std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return h.range >= 0; });
  EXPECT_EQ(met, 0);
}

TEST_P(EveryCar, WheelsAreOnTheGround) {
  const RayCaster caster(drive.world());
  std::vector<Ray> rays;
  for (const Pose& pose : poses_every(drive, 0.5)) {
    for (const double x : {0.0, 2.6}) {
      for (const double y : {-0.75, 0.75}) {
        rays.push_back({(pose * Eigen::Vector3d(x, y, 0.5)).cast<float>(),
                        (pose.rotation * -Eigen::Vector3d::UnitZ()).cast<float>(), 0.0F});
      }
    }
  }
  std::vector<Hit> hits;
  caster.cast(rays, 1e6, 1e6 + 1.0, 0.0F, 3.0F, hits);
  for (const Hit& hit : hits) ASSERT_NEAR(hit.range, 0.5, 0.13);
}

TEST_P(EveryDriveOutside, HitsNoMovingObject) {
  const double ahead = is_car ? 6.0 : 0.9, behind = is_car ? 3.5 : 0.9;
  const double beside = is_car ? 1.5 : 0.6;
  const double duration = to_seconds(drive.trajectory().end() - drive.trajectory().begin());
  for (double t = 0.0; t < duration; t += 0.2) {
    const Pose T_map_base = drive.trajectory().pose(drive.trajectory().begin() + from_seconds(t));
    for (const Mover& mover : drive.world().movers) {
      const auto T_map_mover = mover.pose(t);
      if (!T_map_mover) continue;
      const Eigen::Vector3d p = T_map_base.inverse() * T_map_mover->translation;
      ASSERT_FALSE(p.x() > -behind && p.x() < ahead && std::abs(p.y()) < beside)
          << "at " << t << " s: " << p.transpose();
    }
  }
}

TEST_P(EveryDrive, MotionStaysWithinLimitsOfCarrier) {
  const Limits limits = is_car ? kCar : kCarriers.at(GetParam());
  const SmoothTrajectory& trajectory = drive.trajectory();
  for (Stamp t = trajectory.begin(); t <= trajectory.end();
       t += is_car ? 100'000'000 : 10'000'000) {
    const MotionState state = trajectory.state(t);
    ASSERT_LT(state.velocity_map.norm(), limits.speed);
    ASSERT_LT(state.acceleration_map.norm(), limits.acceleration);
    ASSERT_LT(state.angular_velocity_base.norm(), limits.rate);
    const Eigen::Vector3d v_base = state.T_map_base.rotation.conjugate() * state.velocity_map;
    ASSERT_LT(std::abs(v_base.y()), limits.sideways)
        << "a car does not slide, " << to_seconds(t - trajectory.begin()) << " s";
  }
}

std::string name_of(const testing::TestParamInfo<std::string>& drive) { return drive.param; }

INSTANTIATE_TEST_SUITE_P(Drives, EveryDrive, testing::ValuesIn(all_drives()), name_of);
INSTANTIATE_TEST_SUITE_P(Drives, EveryCar,
                         testing::ValuesIn(names_where([](const std::string& name) {
                           return kCarriers.count(name) == 0;
                         })),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Drives, EveryDriveOutside,
                         testing::ValuesIn(names_where([](const std::string& name) {
                           return name != "elevator";
                         })),
                         name_of);

/// Path lengths that the drive covers twice, m: it was within 5 m at least 60 m earlier.
struct Revisits {
  double same_direction = 0.0;
  double opposite_direction = 0.0;
};

Revisits revisits(const Drive& drive) {
  const std::vector<Pose> poses = poses_every(drive, 0.2);
  std::vector<double> path_length = {0.0};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    path_length.push_back(path_length.back() +
                          (poses[i].translation - poses[i - 1].translation).norm());
  }
  Revisits found;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    double same = 1e9, opposite = 1e9;
    for (std::size_t j = 0; j < i && path_length[i] - path_length[j] > 60.0; ++j) {
      const double distance = (poses[i].translation - poses[j].translation).norm();
      const double turn = std::abs(
          std::remainder(yaw_of(poses[i].rotation) - yaw_of(poses[j].rotation), 2.0 * M_PI));
      if (turn < 0.5) same = std::min(same, distance);
      if (turn > M_PI - 0.5) opposite = std::min(opposite, distance);
    }
    if (same < 5.0) found.same_direction += path_length[i] - path_length[i - 1];
    if (opposite < 5.0) found.opposite_direction += path_length[i] - path_length[i - 1];
  }
  return found;
}

/// Share of the poses of a drive that the one in reverse passes in the opposite direction, within
/// `distance` m.
double share_passed(const std::string& name, double distance) {
  const std::vector<Pose> there = poses_every(drive_of(name), 0.5);
  const std::vector<Pose> back = poses_every(drive_of(name + kReverse), 0.1);
  const auto is_passed = [&](const Pose& pose) {
    return std::any_of(back.begin(), back.end(), [&](const Pose& other) {
      const double turn =
          std::remainder(yaw_of(pose.rotation) - yaw_of(other.rotation), 2.0 * M_PI);
      return (pose.translation - other.translation).norm() < distance &&
             std::abs(turn) > M_PI - 0.3;
    });
  };
  return static_cast<double>(std::count_if(there.begin(), there.end(), is_passed)) /
         static_cast<double>(there.size());
}

TEST(ReverseDrive, PassesTheSameRouteInTheOppositeDirection) {
  EXPECT_GT(share_passed("town", 6.0), 0.85);
  EXPECT_GT(share_passed("open_road", 6.0), 0.9);
  EXPECT_GT(share_passed("car_park", 3.5), 0.9);
}

TEST(ReverseDrive, LeavesTheWorldAsItIs) {
  for (const char* name : {"town", "open_road", "car_park"}) {
    EXPECT_EQ(drive_of(name + kReverse).world().fixed.vertices,
              drive_of(name).world().fixed.vertices)
        << name;
  }
}

TEST(ReverseDrive, IsRefusedWhereItHasNoMeaning) {
  DriveOptions options;
  options.drive = "tunnel";
  options.reverse = true;
  EXPECT_THROW(Drive{options}, ConfigError);
  options.reverse = false;
  options.parked = 1;
  EXPECT_THROW(Drive{options}, ConfigError);
}

/// Vertices of one world that the other one lacks.
std::size_t only_in(const Drive& drive, const Drive& other) {
  const auto less = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  auto vertices = drive.world().fixed.vertices, others = other.world().fixed.vertices;
  std::sort(vertices.begin(), vertices.end(), less);
  std::sort(others.begin(), others.end(), less);
  decltype(vertices) rest;
  std::set_difference(vertices.begin(), vertices.end(), others.begin(), others.end(),
                      std::back_inserter(rest), less);
  return rest.size();
}

TEST(ParkedCars, OfAnotherDayAreOthersAndAllElseStands) {
  for (const char* name : {"town", "car_park"}) {
    DriveOptions options;
    options.drive = name;
    options.parked = 1;
    const Drive other(options);
    options.parked = 2;
    const Drive third(options);
    const std::size_t changed = only_in(other, drive_of(name));
    EXPECT_GT(changed, 1000U) << name;
    EXPECT_GT(only_in(other, third), 1000U) << name;
    EXPECT_LT(changed, other.world().fixed.vertices.size() / 2) << name;
    // What stays is the larger part of both worlds.
    EXPECT_LT(only_in(drive_of(name), other), drive_of(name).world().fixed.vertices.size() / 2)
        << name;
  }
}

TEST(TownDrive, AnotherPassHasOtherTraffic) {
  DriveOptions options;
  options.pass = 1;
  const Drive other(options);
  const Drive& town = drive_of("town");
  EXPECT_EQ(other.world().fixed.vertices, town.world().fixed.vertices);
  const auto moved = other.world().movers.front().T_map_shape.front().translation -
                     town.world().movers.front().T_map_shape.front().translation;
  EXPECT_GT(moved.norm(), 0.1);
  EXPECT_NE(other.gnss().front().latitude_deg, town.gnss().front().latitude_deg);
}

TEST(TownDrive, RevisitsStreetsInBothDirectionsAndEndsNearItsStart) {
  const Drive& drive = drive_of("town");
  const SmoothTrajectory& trajectory = drive.trajectory();
  EXPECT_NEAR(trajectory.length(trajectory.begin(), trajectory.end()), 1000.0, 150.0);
  const Revisits found = revisits(drive);
  EXPECT_GT(found.same_direction, 100.0);
  EXPECT_GT(found.opposite_direction, 200.0);
  EXPECT_TRUE(test::near(trajectory.pose(trajectory.end()).translation,
                         trajectory.pose(trajectory.begin()).translation, 40.0));
}

TEST(TownDrive, HasHalts) {
  const Drive& drive = drive_of("town");
  const SmoothTrajectory& trajectory = drive.trajectory();
  int resting = 0;
  for (Stamp t = trajectory.begin() + 10'000'000'000; t < trajectory.end() - 10'000'000'000;
       t += 100'000'000) {
    if (trajectory.state(t).velocity_map.norm() < 0.02) ++resting;
  }
  EXPECT_GT(resting, 30);
}

TEST(CarParkDrive, VisitsThreeStoreys) {
  const Drive& drive = drive_of("car_park");
  std::vector<double> heights;
  for (const Pose& pose : poses_every(drive, 0.1)) {
    if (std::abs(pose.translation.y() - 27.0) < 1.0) heights.push_back(pose.translation.z());
  }
  const auto near = [&](double z) {
    return std::count_if(heights.begin(), heights.end(),
                         [&](double h) { return std::abs(h - z) < 0.1; });
  };
  EXPECT_GT(near(0.0), 20);
  EXPECT_GT(near(3.0), 20);
  EXPECT_GT(near(6.0), 20);
}

TEST(TwinsDrive, HasStreetsThatLookAlike) {
  const Drive& drive = drive_of("twins");
  const RayCaster caster(drive.world());
  // The same rays from two crossings that are a street apart.
  const auto ranges_from = [&](const Eigen::Vector3d& origin) {
    std::vector<Ray> rays;
    for (double angle = 0.0; angle < 2.0 * M_PI; angle += 0.01) {
      rays.push_back(
          {origin.cast<float>(),
           Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.02).normalized().cast<float>(),
           0.0F});
    }
    std::vector<Hit> hits;
    caster.cast(rays, 1e6, 1e6 + 1.0, 0.0F, 50.0F, hits);
    return hits;
  };
  const Eigen::Vector3d here =
      drive.trajectory().pose(drive.trajectory().begin()).translation + Eigen::Vector3d(30, 0, 1.7);
  const auto a = ranges_from(here), b = ranges_from(here + Eigen::Vector3d(0.0, 70.0, 0.0));
  int alike = 0;
  for (std::size_t i = 0; i < a.size(); ++i) alike += std::abs(a[i].range - b[i].range) < 0.01;
  EXPECT_GT(alike, static_cast<int>(0.98 * static_cast<double>(a.size())));
}

TEST(WalkDrive, TurnsAsFastAsAPerson) {
  const Drive& drive = drive_of("walk");
  double fastest = 0.0;
  for (Stamp t = drive.trajectory().begin(); t < drive.trajectory().end(); t += 20'000'000) {
    fastest = std::max(fastest, drive.trajectory().state(t).angular_velocity_base.norm());
  }
  EXPECT_GT(fastest, 1.3);
}

}  // namespace
}  // namespace lidar_mapping::simulation
