// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"
#include "scenarios/road_drive.hpp"
#include "worlds/buildings.hpp"
#include "worlds/ground.hpp"
#include "worlds/palette.hpp"
#include "worlds/parked_cars.hpp"
#include "worlds/road_strip.hpp"
#include "worlds/street_furniture.hpp"
#include "worlds/vehicles.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x400, kMotion };

// The building has a corner at the origin and its length along x. Two aisles run along it; between
// them are the ramps, one above the other. Dimensions, m, chosen as in usual car parks.
constexpr double kLength = 70.0;
constexpr double kWidth = 36.0;
constexpr double kStorey = 3.0;
constexpr double kSlab = 0.25;
constexpr int kStoreys = 3;
constexpr double kAisleLow = 9.0, kAisleHigh = 27.0, kRampY = 18.0;
constexpr double kRampFoot = 22.0, kRampTop = 50.0, kRampHalfWidth = 2.6;
constexpr double kGate = 3.2;  ///< Half width of the entrance in the west wall, m.

/// The drive enters from the west, makes a round of each storey and takes the ramp to the next one.
std::vector<Eigen::Vector2d> corners() {
  std::vector<Eigen::Vector2d> corners = {{-48.0, kAisleLow}};
  for (int storey = 0; storey < kStoreys; ++storey) {
    if (storey > 0) {
      corners.insert(corners.end(),
                     {{63.0, kRampY}, {63.0, kAisleHigh}, {8.0, kAisleHigh}, {8.0, kAisleLow}});
    }
    corners.insert(corners.end(), {{63.0, kAisleLow}, {63.0, kAisleHigh}, {8.0, kAisleHigh}});
    if (storey + 1 < kStoreys) corners.emplace_back(8.0, kRampY);
  }
  corners.emplace_back(8.0, kAisleLow + 5.0);
  return corners;
}

/// Height of the floor along the path, and the part of the path that is under a roof.
struct Profile {
  std::vector<double> heights;  ///< Every Path::kSpacing metres.
  double covered_from = 0.0;    ///< Station where the roof begins, m.
  double covered_to = 0.0;

  double height(double station) const {
    const auto i = static_cast<std::size_t>(std::max(0.0, station / Path::kSpacing));
    if (i + 1 >= heights.size()) return heights.back();
    const double u = station / Path::kSpacing - static_cast<double>(i);
    return (1.0 - u) * heights[i] + u * heights[i + 1];
  }
};

/// The profile of the same path in the opposite direction.
Profile reversed_profile(Profile profile, const Path& path) {
  std::reverse(profile.heights.begin(), profile.heights.end());
  const double from = profile.covered_from;
  profile.covered_from = path.length() - profile.covered_to;
  profile.covered_to = path.length() - from;
  return profile;
}

bool on_ramp(const Path& path, double s) {
  const Eigen::Vector2d at = path.position(s);
  return std::abs(at.y() - kRampY) < 1.5 && at.x() > kRampFoot && at.x() < kRampTop &&
         std::cos(path.heading(s)) > 0.9;
}

Profile make_profile(const Path& path) {
  Profile profile;
  int storey = 0;
  bool ramp_before = false;
  for (double s = 0.0; s <= path.length(); s += Path::kSpacing) {
    const bool ramp = on_ramp(path, s);
    if (ramp_before && !ramp && ++storey == kStoreys - 1) profile.covered_to = s;
    const double fraction = (path.position(s).x() - kRampFoot) / (kRampTop - kRampFoot);
    profile.heights.push_back(kStorey * (storey + (ramp ? fraction : 0.0)));
    if (profile.covered_from == 0.0 && path.position(s).x() > 0.0) profile.covered_from = s;
    ramp_before = ramp;
  }
  // The length of a car smooths the transitions at both ends of a ramp.
  profile.heights = smoothed(std::move(profile.heights), 14, 3);
  return profile;
}

GroundUnder floor_under(const Path& path, const Profile& profile) {
  return [&path, &profile](double station) {
    const double slope = (profile.height(station + 0.3) - profile.height(station - 0.3)) / 0.6;
    const double heading = path.heading(station);
    return Ground{profile.height(station),
                  slope * Eigen::Vector2d(std::cos(heading), std::sin(heading))};
  };
}

/// A slab whose top is at `z`, with a hole for the ramp from below.
void add_slab(TriangleMesh& mesh, double z) {
  const double y0 = kRampY - kRampHalfWidth, y1 = kRampY + kRampHalfWidth;
  const double low = z - kSlab;
  add_block(mesh, {0.0, 0.0, low}, {kLength, y0, z}, kConcrete);
  add_block(mesh, {0.0, y1, low}, {kLength, kWidth, z}, kConcrete);
  add_block(mesh, {0.0, y0, low}, {kRampFoot, y1, z}, kConcrete);
  add_block(mesh, {kRampTop, y0, low}, {kLength, y1, z}, kConcrete);
}

/// The ramp that leads from `z` to the storey above, with walls at its sides.
void add_ramp(TriangleMesh& mesh, double z) {
  const double y0 = kRampY - kRampHalfWidth, y1 = kRampY + kRampHalfWidth;
  add_quad(mesh, {kRampFoot, y0, z}, {kRampTop, y0, z + kStorey}, {kRampTop, y1, z + kStorey},
           {kRampFoot, y1, z}, kConcrete);
  for (const double y : {y0, y1}) {
    add_quad(mesh, {kRampFoot, y, z}, {kRampTop, y, z}, {kRampTop, y, z + kStorey + 0.9},
             {kRampFoot, y, z + 0.9}, kConcrete);
  }
}

/// A parapet around the storey; with a gate in the west wall of the ground floor.
void add_parapet(TriangleMesh& mesh, double z, bool gate) {
  constexpr double kHeight = 1.05, kThick = 0.2;  // m; chosen, as of usual parapets
  const double top = z + kHeight;
  add_block(mesh, {0.0, 0.0, z}, {kLength, kThick, top}, kConcrete);
  add_block(mesh, {0.0, kWidth - kThick, z}, {kLength, kWidth, top}, kConcrete);
  add_block(mesh, {kLength - kThick, 0.0, z}, {kLength, kWidth, top}, kConcrete);
  if (gate) add_block(mesh, {0.0, 0.0, z}, {kThick, kAisleLow - kGate, top}, kConcrete);
  add_block(mesh, {0.0, gate ? kAisleLow + kGate : 0.0, z}, {kThick, kWidth, top}, kConcrete);
}

void add_columns(TriangleMesh& mesh, double z) {
  for (double x = 4.0; x < kLength; x += 7.75) {
    for (const double y : {5.9, kRampY - 3.4, kRampY + 3.4, kWidth - 5.9}) {
      add_block(mesh, {x - 0.2, y - 0.2, z}, {x + 0.2, y + 0.2, z + kStorey - kSlab}, kConcrete);
    }
  }
}

/// A stair tower and a lift shaft in opposite corners, which make the ends different.
void add_towers(TriangleMesh& mesh, double z, double height) {
  add_block(mesh, {kLength - 5.0, 0.3, z}, {kLength - 0.3, 3.2, z + height}, kPavement);
  add_block(mesh, {0.3, kWidth - 3.0, z}, {3.0, kWidth - 0.3, z + height}, kPavement);
}

void park_cars(TriangleMesh& mesh, double z, Random& random) {
  for (const auto& [y, yaw] : {std::pair{3.0, -0.5 * kPi}, std::pair{kWidth - 3.0, 0.5 * kPi}}) {
    for (double x = 6.5; x < kLength - 7.0; x += 2.6) {
      const double ahead = yaw + (random.chance(0.3) ? kPi : 0.0);
      const double turn = ahead + random.uniform(-0.04, 0.04);
      const double shift = random.uniform(-0.3, 0.3);
      const Random own(random.bits());
      if (!random.chance(0.5)) continue;
      append(mesh, random.chance(0.1) ? make_van(own) : make_car(own),
             {rotation_about_z(turn), {x, y + shift, z}});
    }
  }
}

void add_building(TriangleMesh& mesh, Random& random, std::uint64_t day) {
  constexpr double kFloor = 0.02;  // m; chosen: just above the ground
  add_quad(mesh, {0.0, 0.0, kFloor}, {kLength, 0.0, kFloor}, {kLength, kWidth, kFloor},
           {0.0, kWidth, kFloor}, kConcrete);
  for (int storey = 0; storey < kStoreys; ++storey) {
    const double z = storey * kStorey;
    const bool is_top = storey + 1 == kStoreys;
    if (storey > 0) add_slab(mesh, z);
    if (!is_top) {
      add_ramp(mesh, z);
      add_columns(mesh, z);
    }
    add_parapet(mesh, z, storey == 0);
    add_towers(mesh, z, is_top ? 2.8 : kStorey - kSlab);
    add_parked_cars(mesh, random, day,
                    [z](TriangleMesh& to, Random& own) { park_cars(to, z, own); });
  }
}

/// Houses and trees around, which are seen from the gate and from the top storey.
void add_neighbours(TriangleMesh& mesh, Random& random) {
  const auto house = [&](double x, double y, double yaw) {
    const HousePlan plan{random.uniform(12.0, 20.0), random.uniform(9.0, 12.0),
                         random.integer(2, 5), 0.5};
    const Random own(random.bits());
    const double dx = random.uniform(-2.0, 2.0), dy = random.uniform(-2.0, 2.0);
    add_house(mesh, {rotation_about_z(yaw), {x + dx, y + dy, 0.1}}, plan, own);
  };
  for (double x = -45.0; x < 100.0; x += 26.0) {
    house(x, kWidth + 18.0, 0.0);
    house(x, -18.0, kPi);
  }
  for (double y = -5.0; y < kWidth + 5.0; y += 24.0) {
    house(kLength + 20.0, y, -0.5 * kPi);
    if (std::abs(y - kAisleLow) > 12.0) house(-62.0, y, 0.5 * kPi);
  }
  for (int i = 0; i < 25; ++i) {
    const double foot_y = random.uniform(-14.0, 50.0), foot_x = random.uniform(-50.0, 95.0);
    const Eigen::Vector3d foot(foot_x, foot_y, 0.0);
    const Random own(random.bits());
    const bool on_site =
        foot.x() > -4.0 && foot.x() < kLength + 4.0 && foot.y() > -4.0 && foot.y() < kWidth + 4.0;
    const bool on_drive = std::abs(foot.y() - kAisleLow) < 6.0;
    if (!on_site && !on_drive) add_tree(mesh, foot, random.uniform(5.0, 10.0), own);
  }
}

}  // namespace

Scenario make_car_park(const DriveOptions& options) {
  const Path in = Path::rounded(corners(), 5.5);
  const Path path = options.reverse ? reversed(in, 0.0) : in;
  const Profile profile =
      options.reverse ? reversed_profile(make_profile(in), in) : make_profile(in);
  const std::vector<double> stations =
      stations_along(path, 3.0, 3.0, options.reverse, {5.0, 1.5, 1.2});
  Scenario scenario = car_scenario(
      path, stations, floor_under(path, profile), Random(options.seed, kMotion),
      {{time_at(stations, profile.covered_from), time_at(stations, profile.covered_to)}});
  Random random(options.seed, kMesh);
  add_ground(scenario.world.fixed, Terrain(), {-110.0, -70.0}, {140.0, 110.0}, 10.0, kAsphalt);
  add_building(scenario.world.fixed, random, options.parked);
  add_neighbours(scenario.world.fixed, random);
  return scenario;
}

}  // namespace lidar_mapping::simulation
