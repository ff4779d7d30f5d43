#include <algorithm>
#include <array>
#include <cmath>

#include "mounting.hpp"
#include "palette.hpp"
#include "path.hpp"
#include "scenario.hpp"
#include "smoothing.hpp"
#include "vehicle_motion.hpp"
#include "vehicles.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kMesh = 0x500, kMotion, kPeople };

// A floor of an office: a corridor ring of 2.4 m around a core, rooms outside of it.
constexpr double kRingLength = 30.0;  ///< of the corridor's middle line along x, m
constexpr double kRingWidth = 16.0;
constexpr double kCorridor = 1.2;  ///< half width
constexpr double kRoomDepth = 6.0;
constexpr double kRoomWidth = 6.0;
constexpr double kCeiling = 2.8;
constexpr double kDoor = 0.5;  ///< half width
constexpr double kDoorHeight = 2.1;
constexpr double kWall = 0.12;
constexpr double kCarried = 1.2;  ///< height of base_link, m

/// Along the corridor, into rooms and out again, round the ring and back over the first corridor.
std::vector<Eigen::Vector2d> corners() {
  const double inside = kCorridor + 0.5 * kRoomDepth;  // from the corridor's middle into a room
  const double deep = inside + 1.6;
  const double l = kRingLength, w = kRingWidth;
  // Into the second room of the lower side and round in it, likewise above and at the right.
  return {{1.0, 0.0},
          {9.0, 0.0},
          {9.0, -inside},
          {10.8, -inside},
          {10.8, -deep},
          {7.2, -deep},
          {7.2, -inside},
          {9.0, -inside + 0.4},
          {9.0, 0.0},
          {l, 0.0},
          {l, 9.0},
          {l + inside, 9.0},
          {l + inside, 10.8},
          {l + deep, 10.8},
          {l + deep, 7.2},
          {l + inside, 7.2},
          {l + inside - 0.4, 9.0},
          {l, 9.0},
          {l, w},
          {21.0, w},
          {21.0, w + inside},
          {19.2, w + inside},
          {19.2, w + deep},
          {22.8, w + deep},
          {22.8, w + inside},
          {21.0, w + inside - 0.4},
          {21.0, w},
          {0.0, w},
          {0.0, 0.0},
          {l, -0.2},
          {l, w - 0.2},
          {0.2, w},
          {0.2, 3.0}};
}

/// A wall between two points with a door in its middle, or without.
void add_wall(TriangleMesh& mesh, const Eigen::Vector2d& a, const Eigen::Vector2d& b, bool door,
              Reflectivity paint) {
  const Eigen::Vector2d along = (b - a).normalized(), middle = 0.5 * (a + b);
  const double yaw = std::atan2(along.y(), along.x());
  const auto piece = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, double low,
                         double high) {
    const Eigen::Vector2d centre = 0.5 * (from + to);
    add_box(mesh,
            {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())),
             {centre.x(), centre.y(), 0.5 * (low + high)}},
            {(to - from).norm(), kWall, high - low}, paint);
  };
  if (!door) return piece(a, b, 0.0, kCeiling);
  const Eigen::Vector2d left = middle - kDoor * along, right = middle + kDoor * along;
  piece(a, left, 0.0, kCeiling);
  piece(right, b, 0.0, kCeiling);
  piece(left, right, kDoorHeight, kCeiling);
}

void add_furniture(TriangleMesh& mesh, const Eigen::Vector2d& wall, const Eigen::Vector2d& along,
                   const Eigen::Vector2d& inwards, Random& random) {
  const double yaw = std::atan2(along.y(), along.x());
  const auto thing = [&](double s, double in, const Eigen::Vector3d& size, double foot) {
    const Eigen::Vector2d at = wall + s * along + in * inwards;
    add_box(mesh,
            {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())),
             {at.x(), at.y(), foot + 0.5 * size.z()}},
            size, static_cast<Reflectivity>(random.integer(40, 190)));
  };
  // Shelves and tables stand at the outer wall and in the corners, clear of the way.
  const double outer = kRoomDepth - 0.35;
  thing(random.uniform(-2.0, -1.0), outer,
        {random.uniform(0.8, 1.8), 0.45, random.uniform(0.8, 2.1)}, 0.0);
  thing(random.uniform(1.0, 2.0), outer, {random.uniform(0.8, 1.6), 0.5, 0.06}, 0.74);
  thing(random.uniform(0.6, 1.9), outer - 0.1, {0.4, 0.2, 0.4}, 0.8);
  thing(-2.55, random.uniform(0.6, 1.3), {0.5, random.uniform(0.6, 1.0), random.uniform(0.7, 1.9)},
        0.0);
  thing(2.55, random.uniform(0.6, 1.3), {0.5, random.uniform(0.5, 1.0), random.uniform(0.4, 1.2)},
        0.0);
}

/// A row of rooms along a side of the ring. `begin` lies on the corridor's outer wall.
void add_rooms(TriangleMesh& mesh, const Eigen::Vector2d& begin, const Eigen::Vector2d& along,
               double length, Random& random) {
  const Eigen::Vector2d inwards(along.y(), -along.x());
  const int rooms = static_cast<int>(std::lround(length / kRoomWidth));
  for (int i = 0; i < rooms; ++i) {
    const Eigen::Vector2d a = begin + i * kRoomWidth * along, b = a + kRoomWidth * along;
    const auto paint = static_cast<Reflectivity>(random.integer(110, 210));
    add_wall(mesh, a, b, true, paint);
    add_wall(mesh, a, a + kRoomDepth * inwards, false, paint);
    add_wall(mesh, a + kRoomDepth * inwards, b + kRoomDepth * inwards, false, paint);
    if (i + 1 == rooms) add_wall(mesh, b, b + kRoomDepth * inwards, false, paint);
    add_furniture(mesh, 0.5 * (a + b), along, inwards, random);
  }
}

/// Cupboards, plants and pipes along the core, so that the corridor is not the same everywhere.
void add_corridor_things(TriangleMesh& mesh, Random& random) {
  const double x1 = kRingLength - kCorridor, y1 = kRingWidth - kCorridor;
  for (double x = 3.0; x < x1 - 1.0; x += random.uniform(2.5, 6.0)) {
    for (const double y : {kCorridor - 0.12, y1 + 0.12}) {
      const double height = random.uniform(0.4, 2.0), length = random.uniform(0.3, 1.2);
      if (random.chance(0.4)) continue;
      add_box(mesh, Pose{Eigen::Quaterniond::Identity(), {x, y, 0.5 * height}},
              {length, 0.3, height}, static_cast<Reflectivity>(random.integer(40, 190)));
    }
  }
}

void add_floor(TriangleMesh& mesh, Random& random) {
  const double l = kRingLength, w = kRingWidth, c = kCorridor, out = c + kRoomDepth;
  for (const double z : {0.0, kCeiling}) {
    add_quad(mesh, {-out, -out, z}, {l + out, -out, z}, {l + out, w + out, z}, {-out, w + out, z},
             z > 0.0 ? Reflectivity{190} : Reflectivity{75});
  }
  const std::array<Eigen::Vector2d, 4> core = {
      Eigen::Vector2d{c, c}, {l - c, c}, {l - c, w - c}, {c, w - c}};
  for (int i = 0; i < 4; ++i) add_wall(mesh, core[i], core[(i + 1) % 4], false, 150);
  add_rooms(mesh, {0.0, -c}, {1.0, 0.0}, l, random);
  add_rooms(mesh, {l + c, -0.0}, {0.0, 1.0}, 12.0, random);
  add_rooms(mesh, {l, w + c}, {-1.0, 0.0}, l, random);
  add_rooms(mesh, {-c, w}, {0.0, -1.0}, 12.0, random);
  // What the rows of rooms leave open at the corners.
  add_wall(mesh, {-c, w - 12.0}, {-c, -c}, false, 160);
  add_wall(mesh, {-c, -c}, {0.0, -c}, false, 160);
  add_wall(mesh, {l, -c}, {l + c, -c}, false, 160);
  add_wall(mesh, {l + c, -c}, {l + c, 0.0}, false, 160);
  add_wall(mesh, {l + c, 12.0}, {l + c, w + c}, false, 160);
  add_wall(mesh, {l + c, w + c}, {l, w + c}, false, 160);
  add_wall(mesh, {0.0, w + c}, {-c, w + c}, false, 160);
  add_wall(mesh, {-c, w + c}, {-c, w}, false, 160);
  add_corridor_things(mesh, random);
}

/// Steps and a hand that is never still, over a smooth walk.
SmoothTrajectory walked(const Path& path, const std::vector<double>& stations, Random random) {
  std::array<double, 8> phase{};
  for (double& p : phase) p = random.uniform(0.0, 2.0 * M_PI);
  std::vector<Vector6d> control(stations.size());
  constexpr double kStride = 0.68;  // m per step
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double s = stations[i], t = static_cast<double>(i) * kControlStep;
    const double step = 2.0 * M_PI * s / kStride;
    control[i] << path.position(s), kCarried + 0.02 * std::sin(step) + 0.01 * std::sin(1.1 * t),
        path.heading(s) + 0.04 * std::sin(0.5 * step + phase[0]) +
            0.05 * std::sin(0.9 * t + phase[1]),
        0.04 * std::sin(step + phase[2]) + 0.06 * std::sin(0.7 * t + phase[3]),
        0.03 * std::sin(0.5 * step + phase[4]) + 0.05 * std::sin(0.8 * t + phase[5]);
  }
  return SmoothTrajectory(kDriveBegin, kControlStep, smoothed(std::move(control), 4, 3));
}

/// Somebody shows the way, four metres ahead.
void add_guide(World& world, const std::vector<double>& stations, const Path& path, Random random) {
  Mover ahead;
  ahead.shape = world.shapes.size();
  for (std::size_t i = 0; i < stations.size(); i += 5) {
    const double s = std::min(stations[i] + 4.0, path.length());
    const Eigen::Vector2d at = path.position(s);
    ahead.T_map_shape.push_back(
        {Eigen::Quaterniond(Eigen::AngleAxisd(path.heading(s), Eigen::Vector3d::UnitZ())),
         {at.x(), at.y(), 0.0}});
  }
  world.shapes.push_back(make_pedestrian(Random(random.bits())));
  world.movers.push_back(std::move(ahead));
}

}  // namespace

Scenario make_walk(const DriveOptions& options) {
  const Path path = Path::rounded(corners(), 0.5, 0.2);
  // Corners are taken at up to 1.5 rad/s: speed * curvature = lateral / speed.
  const std::vector<double> stations =
      stations_over_time(path, 0.5, path.length() - 5.0, {1.3, 1.1, 0.9},
                         {{0.3 * path.length(), 2.0}, {0.7 * path.length(), 2.0}});
  Scenario scenario{{},
                    walked(path, stations, Random(options.seed, kMotion)),
                    hand_held_mounting(),
                    {{0.0, static_cast<double>(stations.size()) * kControlStep}}};
  Random random(options.seed, kMesh);
  add_floor(scenario.world.fixed, random);
  if (options.movers) add_guide(scenario.world, stations, path, Random(options.seed, kPeople));
  return scenario;
}

}  // namespace lidar_mapping::simulation
