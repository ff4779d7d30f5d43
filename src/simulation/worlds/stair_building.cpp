// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/stair_building.hpp"

#include <algorithm>
#include <cmath>

#include "worlds/palette.hpp"

namespace lidar_mapping::simulation {

namespace {

// Dimensions, chosen as in usual buildings: steps of 16 cm by 28 cm.
constexpr double kHalfWidth = 1.3;   ///< Half width of corridors and stairwell, m.
constexpr double kEast = 4.2;        ///< x of the end of the stairwell.
constexpr double kSlab = 0.2;        ///< Thickness, m; chosen, like those below.
constexpr double kWall = 0.12;       ///< Thickness, m.
constexpr double kDoorHeight = 2.1;  ///< m
constexpr double kLiftDoor = 0.5;    ///< half width
constexpr double kWell = 0.1;        ///< Half of the gap between the flights, m.
constexpr int kSteps = 10;           ///< Steps of a flight.
constexpr double kTread = kFlightLength / kSteps;
constexpr double kRise = 0.5 * kStairStorey / kSteps;  ///< m

/// A wall along x; its inner face is in the plane y = side * kHalfWidth.
void add_side_wall(TriangleMesh& mesh, double x0, double x1, double side, double low, double high,
                   Reflectivity paint) {
  const double inner = side * kHalfWidth, outer = side * (kHalfWidth + kWall);
  add_block(mesh, {x0, std::min(inner, outer), low}, {x1, std::max(inner, outer), high}, paint);
}

void add_walls(TriangleMesh& mesh, double z, Reflectivity paint) {
  const double top = z + kStairStorey;
  add_side_wall(mesh, kCorridorEnd, kEast, -1.0, z, top, paint);
  add_side_wall(mesh, kCorridorEnd, kLiftX - kLiftDoor, 1.0, z, top, paint);
  add_side_wall(mesh, kLiftX - kLiftDoor, kLiftX + kLiftDoor, 1.0, z + kDoorHeight, top, paint);
  add_side_wall(mesh, kLiftX + kLiftDoor, kEast, 1.0, z, top, paint);
  for (const double x : {kCorridorEnd - kWall, kEast}) {
    add_block(mesh, {x, -kHalfWidth, z}, {x + kWall, kHalfWidth, top}, paint);
  }
  // A lintel where the corridor ends and the stairwell begins.
  add_block(mesh, {-1.6, -kHalfWidth, z + 2.35}, {-1.5, kHalfWidth, top - kSlab}, paint);
}

void add_flight(TriangleMesh& mesh, double foot, double towards, double y0, double y1, double z) {
  for (int i = 0; i < kSteps; ++i) {
    const double from = foot + towards * kTread * i, to = from + towards * kTread;
    const double top = z + kRise * (i + 1);
    add_block(mesh, {std::min(from, to), y0, top - 0.32}, {std::max(from, to), y1, top}, kConcrete);
  }
}

void add_rail(TriangleMesh& mesh, double foot, double towards, double y, double z) {
  const Eigen::Vector3d rise(towards * kFlightLength, 0.0, 0.5 * kStairStorey);
  const Eigen::Vector3d low(foot, y, z + 0.95);
  add_tube(mesh, low, rise, 0.03, 0.03, 6, kSteel);
  for (int i = 1; i < kSteps; i += 2) {
    const Eigen::Vector3d top = low + rise * (i / static_cast<double>(kSteps));
    add_tube(mesh, top - Eigen::Vector3d(0.0, 0.0, 0.9), {0.0, 0.0, 0.9}, 0.012, 0.012, 5, kSteel);
  }
}

/// Two flights and the landing between them.
void add_stairs(TriangleMesh& mesh, double z) {
  const double middle = z + 0.5 * kStairStorey;
  add_flight(mesh, 0.0, 1.0, kWell, kHalfWidth, z);
  add_flight(mesh, kFlightLength, -1.0, -kHalfWidth, -kWell, middle);
  add_block(mesh, {kFlightLength, -kHalfWidth, middle - kSlab}, {kEast, kHalfWidth, middle},
            kConcrete);
  add_rail(mesh, 0.0, 1.0, 0.5 * kWell, z);
  add_rail(mesh, kFlightLength, -1.0, -0.5 * kWell, middle);
}

/// Adds doors, frames, cupboards and heaters, so that all storeys differ.
void add_furniture(TriangleMesh& mesh, double z, Random& random) {
  const auto paint = [&] { return static_cast<Reflectivity>(random.integer(40, 200)); };
  for (double x = kCorridorEnd + 1.0; x < -3.0; x += random.uniform(1.6, 3.2)) {
    const double width = random.uniform(0.5, 1.1), kind = random.uniform();
    const double side = random.chance(0.6) ? -1.0 : 1.0, deep = random.uniform(0.15, 0.35);
    const double height = random.uniform(0.6, 2.0);
    const bool is_at_lift = side > 0.0 && std::abs(x + 0.5 * width - kLiftX) < 1.3;
    if (is_at_lift || kind < 0.2) continue;
    const double depth = kind < 0.6 ? deep : 0.04;
    const double low = kind < 0.8 ? z : z + 1.1, high = kind < 0.6 ? z + height : z + 2.0;
    const double wall = side * kHalfWidth, face = side * (kHalfWidth - depth);
    add_block(mesh, {x, std::min(wall, face), low}, {x + width, std::max(wall, face), high},
              paint());
  }
  const double y = random.uniform(-0.9, 0.3), width = random.uniform(0.4, 0.8);
  const double sill = z + 0.5 * kStairStorey + random.uniform(0.1, 1.0);
  const Reflectivity of_window = paint();
  const double top = sill + random.uniform(0.4, 0.8);
  add_block(mesh, {kEast - 0.1, y, sill}, {kEast, y + width, top}, of_window);
}

void add_shaft(TriangleMesh& mesh) {
  const double top = kStairStoreys * kStairStorey;
  const double x0 = kLiftX - 1.0, x1 = kLiftX + 1.0, y1 = kLiftY + 1.25;
  add_block(mesh, {x0 - kWall, kHalfWidth, -0.5}, {x0, y1, top}, kConcrete);
  add_block(mesh, {x1, kHalfWidth, -0.5}, {x1 + kWall, y1, top}, kConcrete);
  add_block(mesh, {x0, y1, -0.5}, {x1, y1 + kWall, top}, kConcrete);
}

}  // namespace

void add_stair_building(TriangleMesh& mesh, Random random) {
  for (int storey = 0; storey <= kStairStoreys; ++storey) {
    const double z = storey * kStairStorey;
    const bool is_roof = storey == kStairStoreys;
    // The lowest floor continues under the stairs, and the roof above them.
    add_block(mesh, {kCorridorEnd, -kHalfWidth, z - kSlab},
              {storey == 0 || is_roof ? kEast : 0.0, kHalfWidth, z}, 85);
    if (is_roof) break;
    add_walls(mesh, z, static_cast<Reflectivity>(random.integer(120, 200)));
    add_furniture(mesh, z, random);
    if (storey + 1 < kStairStoreys) add_stairs(mesh, z);
  }
  add_shaft(mesh);
}

std::vector<Ground> floor_in_stair_building(const Track& track) {
  std::vector<Ground> floor;
  double storey = 0.0;
  bool was_up_lane = true;
  for (const TrackState& state : track.states()) {
    const bool is_up_lane = state.position.y() >= 0.0;
    const double x = state.position.x();
    // On the main landing the stairs of two storeys meet.
    if (x < 0.5 * kFlightLength && is_up_lane != was_up_lane) storey += is_up_lane ? 1.0 : -1.0;
    was_up_lane = is_up_lane;
    const double along = std::clamp(x / kFlightLength, 0.0, 1.0);
    const double fraction_of_storey = is_up_lane ? 0.5 * along : 1.0 - 0.5 * along;
    floor.push_back({(storey + fraction_of_storey) * kStairStorey, Eigen::Vector2d::Zero()});
  }
  return floor;
}

TriangleMesh make_lift_car() {
  // Half width, half depth, height and thickness of the sheets, m; chosen, as of a large lift.
  constexpr double kHalf = 0.85, kDeep = 1.1, kHeight = 2.25, kSheet = 0.04;
  TriangleMesh car;
  for (const double z : {-0.1, kHeight}) {
    add_block(car, {-kHalf, -kDeep, z}, {kHalf, kDeep, z + 0.1}, kSteel);
  }
  for (const double x : {-kHalf - kSheet, kHalf}) {
    add_block(car, {x, -kDeep, 0.0}, {x + kSheet, kDeep, kHeight}, kSteel);
  }
  add_block(car, {-kHalf, kDeep, 0.0}, {kHalf, kDeep + kSheet, kHeight}, kSteel);
  for (const double x : {-kHalf, kLiftDoor}) {
    add_block(car, {x, -kDeep, 0.0}, {x + kHalf - kLiftDoor, -kDeep + kSheet, kHeight}, kSteel);
  }
  add_block(car, {-kLiftDoor, -kDeep, kDoorHeight}, {kLiftDoor, -kDeep + kSheet, kHeight}, kSteel);
  add_tube(car, {-0.7, kDeep - 0.06, 0.9}, {1.4, 0.0, 0.0}, 0.02, 0.02, 6, kSteel);
  add_block(car, {kHalf - 0.03, -0.8, 0.9}, {kHalf, -0.6, 1.6}, kSign);
  return car;
}

TriangleMesh make_lift_door() {
  TriangleMesh door;
  add_block(door, {-kLiftDoor, -0.02, 0.0}, {kLiftDoor, 0.02, kDoorHeight}, kSteel);
  return door;
}

}  // namespace lidar_mapping::simulation
