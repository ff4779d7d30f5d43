// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "scenarios/road_drive.hpp"
#include "worlds/town_layout.hpp"
#include "worlds/town_world.hpp"
#include "worlds/traffic.hpp"

namespace lidar_mapping::simulation {

namespace {

enum Stream : std::uint64_t { kLayout = 1, kTerrain, kMesh, kTraffic, kMotion };

constexpr double kTurnRadius = 8.0;  ///< m; chosen: a car's smallest is 5 to 6
/// Station where a drive begins on its first street, m; chosen: behind the first crossing.
constexpr double kBeginOfDrive = 22.0;

/// A grid of streets and a drive over its crossings.
struct TownPlan {
  int columns = 6;
  int rows = 6;
  bool rows_alike = false;
  double slope = 0.035;  ///< Slope of the steepest hills, rise per run.
  std::vector<Crossing> route;
  double end_before = 95.0;   ///< The drive ends this far before the last crossing of the route, m.
  std::vector<double> halts;  ///< Fractions of the length of the route at which the vehicle stops.
  int road_users = 140;
  std::uint64_t variant = 0;  ///< Distinguishes the worlds of different plans with the same seed.
};

/// The route including all crossings between those that are given.
std::vector<Crossing> with_all_crossings(const std::vector<Crossing>& route) {
  std::vector<Crossing> all = {route.front()};
  for (const Crossing& next : route) {
    while (all.back().column != next.column || all.back().row != next.row) {
      Crossing step = all.back();
      step.column += (next.column > step.column) - (next.column < step.column);
      if (step.column == all.back().column) {
        step.row += (next.row > step.row) - (next.row < step.row);
      }
      all.push_back(step);
    }
  }
  return all;
}

void add_lanes(std::vector<TrafficLane>& lanes, const TownLayout& layout,
               std::vector<Crossing> crossings, double half_width) {
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
}

std::vector<TrafficLane> traffic_lanes(const TownLayout& layout) {
  std::vector<TrafficLane> lanes;
  for (int row = 0; row < layout.rows(); ++row) {
    add_lanes(lanes, layout, with_all_crossings({{0, row}, {layout.columns() - 1, row}}),
              layout.row_half_width(row));
  }
  for (int column = 0; column < layout.columns(); ++column) {
    add_lanes(lanes, layout, with_all_crossings({{column, 0}, {column, layout.rows() - 1}}),
              layout.column_half_width(column));
  }
  return lanes;
}

Scenario make_planned_town(const TownPlan& plan, const DriveOptions& options) {
  const std::uint64_t seed = mix64(options.seed) ^ plan.variant;
  const std::uint64_t day = day_seed(options, seed);
  const TownLayout layout(plan.columns, plan.rows, plan.rows_alike, Random(seed, kLayout));
  const Terrain terrain(Random(seed, kTerrain), 5, 180.0, 420.0, plan.slope);
  std::vector<Crossing> route = with_all_crossings(plan.route);
  if (options.reverse) std::reverse(route.begin(), route.end());
  const Path path = Path::rounded(layout.lane_corners(route, kLaneOffset), kTurnRadius)
                        .weaving(0.2, Random(day, kMotion).uniform(0.0, 6.0));
  std::vector<Halt> halts;
  for (const double fraction : plan.halts) halts.push_back({fraction * path.length(), 4.0});
  const std::vector<double> stations =
      stations_along(path, kBeginOfDrive, plan.end_before, options.reverse, {}, halts);
  Scenario scenario =
      car_scenario(path, stations, ground_along(path, terrain), Random(day, kMotion));
  scenario.world.fixed = make_town_mesh(layout, terrain, Random(seed, kMesh), options.parked);
  if (options.movers) {
    Random random(day, kTraffic);
    add_car_ahead(scenario.world, path, stations, terrain, Random(random.bits()));
    add_traffic(scenario.world, traffic_lanes(layout), terrain, scenario.trajectory,
                plan.road_users, Random(random.bits()));
  }
  return scenario;
}

}  // namespace

Scenario make_town(const DriveOptions& options) {
  TownPlan plan;
  // A round of a block, its first side again, a round of the block behind it, and back over three
  // streets in the opposite direction.
  plan.route = {{2, 2}, {3, 2}, {3, 3}, {2, 3}, {2, 2}, {3, 2}, {4, 2}, {4, 3},
                {3, 3}, {3, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 2}, {2, 2}, {1, 2}};
  plan.halts = {0.22, 0.61};
  return make_planned_town(plan, options);
}

Scenario make_figure_eight(const DriveOptions& options) {
  TownPlan plan;
  plan.route = {{2, 2}, {3, 2}, {3, 3}, {2, 3}, {2, 2}, {2, 1}, {1, 1}, {1, 2},
                {2, 2}, {3, 2}, {3, 3}, {2, 3}, {2, 2}, {2, 1}, {1, 1}};
  plan.halts = {0.35};
  plan.variant = 8;
  return make_planned_town(plan, options);
}

Scenario make_twins(const DriveOptions& options) {
  TownPlan plan;
  plan.rows_alike = true;
  plan.slope = 0.0;
  // Eastwards, westwards and eastwards again through three streets that look alike, then back to
  // the first of them.
  plan.route = {{1, 1}, {3, 1}, {3, 2}, {1, 2}, {1, 3}, {3, 3}, {3, 1}, {1, 1}, {0, 1}};
  plan.halts = {0.5};
  plan.variant = 2;
  return make_planned_town(plan, options);
}

Scenario make_city(const DriveOptions& options) {
  const std::vector<Crossing> round = {{1, 1}, {8, 1}, {8, 7}, {6, 7}, {6, 3},
                                       {4, 3}, {4, 7}, {2, 7}, {2, 4}, {1, 4}};
  TownPlan plan;
  plan.columns = 10;
  plan.rows = 9;
  plan.variant = 100;
  plan.road_users = 400;
  for (int i = 0; i < options.rounds; ++i) {
    plan.route.insert(plan.route.end(), round.begin(), round.end());
    plan.halts.push_back((i + 0.4) / options.rounds);
  }
  plan.route.push_back(round[0]);
  plan.route.push_back(round[1]);
  plan.end_before = 500.0;
  return make_planned_town(plan, options);
}

}  // namespace lidar_mapping::simulation
