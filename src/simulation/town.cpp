#include <algorithm>
#include <cmath>
#include <utility>

#include "mounting.hpp"
#include "scenario.hpp"
#include "town_layout.hpp"
#include "town_world.hpp"
#include "traffic.hpp"
#include "vehicle_motion.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kLayout = 1, kTerrain, kMesh, kTraffic, kMotion };

constexpr int kColumns = 6;
constexpr int kRows = 6;
constexpr double kTurnRadius = 7.5;

/// A round of a block, its first side again, a round of the block behind it and back over three
/// streets against their first direction.
std::vector<Crossing> route() {
  return {{2, 2}, {3, 2}, {3, 3}, {2, 3}, {2, 2}, {3, 2}, {4, 2}, {4, 3},
          {3, 3}, {3, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 2}, {2, 2}, {1, 2}};
}

std::vector<TrafficLane> traffic_lanes(const TownLayout& layout) {
  std::vector<TrafficLane> lanes;
  const auto add = [&](std::vector<Crossing> crossings, double half_width) {
    for (int direction = 0; direction < 2; ++direction) {
      lanes.push_back({Path::rounded(layout.lane_corners(crossings, kLaneOffset), 30.0)});
      TrafficLane pavement{Path::rounded(layout.lane_corners(crossings, half_width + 1.2), 2.0)};
      pavement.slowest = 0.9;
      pavement.fastest = 1.7;
      pavement.pedestrians = true;
      pavement.height = kKerbHeight;
      lanes.push_back(std::move(pavement));
      std::reverse(crossings.begin(), crossings.end());
    }
  };
  for (int row = 0; row < layout.rows(); ++row) {
    std::vector<Crossing> crossings;
    for (int column = 0; column < layout.columns(); ++column) crossings.push_back({column, row});
    add(std::move(crossings), layout.row_half_width(row));
  }
  for (int column = 0; column < layout.columns(); ++column) {
    std::vector<Crossing> crossings;
    for (int row = 0; row < layout.rows(); ++row) crossings.push_back({column, row});
    add(std::move(crossings), layout.column_half_width(column));
  }
  return lanes;
}

}  // namespace

Scenario make_town(const DriveOptions& options) {
  const TownLayout layout(kColumns, kRows, Random(options.seed, kLayout));
  const Terrain terrain(Random(options.seed, kTerrain), 5, 180.0, 420.0, 0.035);
  const Path path = Path::rounded(layout.lane_corners(route(), kLaneOffset), kTurnRadius)
                        .weaving(0.2, 0.1 * static_cast<double>(options.seed % 60));
  const double begin = 22.0, end = path.length() - 95.0;
  const std::vector<double> stations = stations_over_time(
      path, begin, end, {}, {{0.22 * path.length(), 4.0}, {0.61 * path.length(), 5.0}});
  const auto ground = [&](double station) {
    const Eigen::Vector2d at = path.position(station);
    return Ground{terrain.height(at), terrain.gradient(at)};
  };
  Scenario scenario{{},
                    vehicle_trajectory(path, stations, ground, Random(options.seed, kMotion)),
                    car_mounting(),
                    {}};
  scenario.world.fixed = make_town_mesh(layout, terrain, Random(options.seed, kMesh));
  if (options.movers) {
    Random random(options.seed, kTraffic);
    add_car_ahead(scenario.world, path, stations, terrain, Random(random.bits()));
    add_traffic(scenario.world, traffic_lanes(layout), terrain, scenario.trajectory, 140,
                Random(random.bits()));
  }
  return scenario;
}

}  // namespace lidar_mapping::simulation
