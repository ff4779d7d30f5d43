// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/traffic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/vehicle_motion.hpp"
#include "worlds/ground.hpp"
#include "worlds/vehicles.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kStep = 0.1;  ///< Between the poses of a mover, s; chosen: the period of a scan.

/// Half lengths of the rectangle around a road user that must stay free.
struct Clearance {
  double along;
  double across;
};

Clearance clearance(bool pedestrian) {
  return pedestrian ? Clearance{3.0, 1.6} : Clearance{8.0, 2.3};
}

bool conflicts(const Pose& a, const Pose& b, const Clearance& clear_area) {
  const Eigen::Vector3d between = b.translation - a.translation;
  if (between.squaredNorm() > 2.0 * clear_area.along * clear_area.along) return false;
  const auto too_close = [&](const Eigen::Vector3d& p) {
    return std::abs(p.x()) < clear_area.along && std::abs(p.y()) < clear_area.across;
  };
  return too_close(a.rotation.conjugate() * between) ||
         too_close(b.rotation.conjugate() * -between);
}

/// Compares samples at the same instants only: the motion between them is much smaller than the
/// clearance.
bool conflicts(const Mover& mover, const Mover& other, const Clearance& clear_area) {
  const auto size = static_cast<std::ptrdiff_t>(mover.T_map_shape.size());
  const auto others = static_cast<std::ptrdiff_t>(other.T_map_shape.size());
  const std::ptrdiff_t ahead = std::lround((mover.begin_s - other.begin_s) / kStep);
  const std::ptrdiff_t last = std::min(size, others - ahead);
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -ahead); i < last; i += 2) {
    if (conflicts(mover.T_map_shape[i], other.T_map_shape[i + ahead], clear_area)) return true;
  }
  return false;
}

/// The vehicle itself as a mover, so that it is checked like all others.
Mover ego_vehicle(const SmoothTrajectory& trajectory) {
  Mover mover;
  const double duration = to_seconds(trajectory.end() - trajectory.begin());
  for (double t = 0.0; t <= duration; t += kStep) {
    mover.T_map_shape.push_back(trajectory.pose(trajectory.begin() + from_seconds(t)));
  }
  return mover;
}

Mover travel(const TrafficLane& lane, const Terrain& terrain, double begin_s, double speed) {
  Mover mover;
  mover.begin_s = begin_s;
  for (double s = 0.0; s < lane.path.length(); s += speed * kStep) {
    Pose pose = on_slope(terrain, lane.path.position(s), lane.path.heading(s));
    pose.translation.z() += lane.height;
    mover.T_map_shape.push_back(pose);
  }
  return mover;
}

TriangleMesh draw_shape(bool pedestrian, Random& random) {
  const Random own(random.bits());
  if (pedestrian) return make_pedestrian(own);
  return random.chance(0.2) ? make_van(own) : make_car(own);
}

}  // namespace

void add_traffic(World& world, const std::vector<TrafficLane>& lanes, const Terrain& terrain,
                 const SmoothTrajectory& trajectory, int count, Random random) {
  const Mover vehicle = ego_vehicle(trajectory);
  const double duration = to_seconds(trajectory.end() - trajectory.begin());
  int added = 0;
  for (int attempt = 0; attempt < 6 * count && added < count; ++attempt) {
    const TrafficLane& lane = lanes[random.integer(0, static_cast<int>(lanes.size()) - 1)];
    const double speed = random.uniform(lane.slowest, lane.fastest);
    const double begin_s = random.uniform(-lane.path.length() / speed, duration);
    Mover mover = travel(lane, terrain, begin_s, speed);
    const Clearance clear_area = clearance(lane.pedestrians);
    const bool blocked =
        conflicts(mover, vehicle, clear_area) ||
        std::any_of(world.movers.begin(), world.movers.end(),
                    [&](const Mover& other) { return conflicts(mover, other, clear_area); });
    TriangleMesh shape = draw_shape(lane.pedestrians, random);
    if (blocked) continue;
    world.add(std::move(shape), std::move(mover));
    ++added;
  }
}

void add_car_ahead(World& world, const Path& path, const std::vector<double>& stations,
                   const Terrain& terrain, Random random) {
  Mover mover;
  const int stride = static_cast<int>(std::lround(kStep / kControlStep));
  for (std::size_t i = 0; i < stations.size(); i += stride) {
    const double gap = 17.0 + 6.0 * std::sin(stations[i] / 60.0);
    const double s = std::min(stations[i] + gap, path.length());
    mover.T_map_shape.push_back(on_slope(terrain, path.position(s), path.heading(s)));
  }
  world.add(make_car(Random(random.bits())), std::move(mover));
}

}  // namespace lidar_mapping::simulation
