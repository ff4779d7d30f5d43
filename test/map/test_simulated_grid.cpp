// SPDX-License-Identifier: BSD-3-Clause
// A planner can use the 2D grids of simulated drives.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "lidar_mapping/map/write_products.hpp"

#include "simulated_key_frames.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

constexpr std::uint8_t kFree = 254;
constexpr std::uint8_t kOccupied = 0;

/// grid.pgm and grid.yaml as map_server reads them.
class Grid {
 public:
  explicit Grid(const std::filesystem::path& folder) {
    const YAML::Node yaml = YAML::LoadFile((folder / "grid.yaml").string());
    cell_ = yaml["resolution"].as<double>();
    x_ = yaml["origin"][0].as<double>();
    y_ = yaml["origin"][1].as<double>();
    std::ifstream file(folder / "grid.pgm", std::ios::binary);
    std::string magic;
    int largest = 0;
    file >> magic >> columns_ >> rows_ >> largest;
    file.get();
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
  }

  using Cell = std::pair<int, int>;  // column, row from below

  double size() const { return cell_; }
  const std::string& bytes() const { return bytes_; }
  Cell cell_at(const Eigen::Vector2d& p) const {
    return {static_cast<int>(std::floor((p.x() - x_) / cell_)),
            static_cast<int>(std::floor((p.y() - y_) / cell_))};
  }
  Eigen::Vector2d centre(const Cell& cell) const {
    return {x_ + (cell.first + 0.5) * cell_, y_ + (cell.second + 0.5) * cell_};
  }
  std::uint8_t at(const Cell& cell) const {
    const auto [column, row] = cell;
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return 205;
    const int line = rows_ - 1 - row;
    return static_cast<std::uint8_t>(bytes_[line * columns_ + column]);
  }

  double free_fraction(const std::set<Cell>& cells) const {
    const auto free = std::count_if(cells.begin(), cells.end(),
                                    [&](const Cell& cell) { return at(cell) == kFree; });
    return static_cast<double>(free) / static_cast<double>(cells.size());
  }

  /// All free cells that are connected to `start` by free cells.
  std::set<Cell> reachable_from(const Cell& start) const {
    std::set<Cell> reached = {start};
    std::deque<Cell> queue = {start};
    while (!queue.empty()) {
      const auto [column, row] = queue.front();
      queue.pop_front();
      for (const Cell& next : {Cell{column + 1, row}, Cell{column - 1, row}, Cell{column, row + 1},
                               Cell{column, row - 1}}) {
        if (at(next) == kFree && reached.insert(next).second) queue.push_back(next);
      }
    }
    return reached;
  }

 private:
  double cell_ = 0.0;
  double x_ = 0.0;
  double y_ = 0.0;
  int columns_ = 0;
  int rows_ = 0;
  std::string bytes_;
};

/// The key frames without moving objects, which only a simulation knows.
class StaticClouds : public CloudSource {
 public:
  explicit StaticClouds(test::SimulatedKeyFrames& frames) : frames_(frames) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    auto static_cloud = std::make_shared<PointCloud>();
    const PointCloudPtr all = frames_.cloud(index);
    for (std::size_t i = 0; i < all->size(); ++i) {
      if (frames_.moving(index)[i] == 0) static_cloud->points.push_back(all->points[i]);
    }
    return static_cloud;
  }

 private:
  test::SimulatedKeyFrames& frames_;
};

/// A section of a simulated drive and the grid of its key frames.
class DriveWithGrid {
 public:
  DriveWithGrid(const std::string& name, const std::string& lidar, std::size_t thinning,
                double begin_s, double end_s)
      : drive_(options(name, lidar, end_s)), frames_(drive_, begin_s, end_s, 2.0, thinning) {
    const Stamp begin = frames_.poses.poses.front().stamp;
    const Stamp end = frames_.poses.poses.back().stamp;
    for (Stamp stamp = begin; stamp <= end; stamp += from_seconds(0.01)) {
      const Eigen::Vector3d p = drive_.trajectory().pose(stamp).translation;
      path_.emplace_back(p.head<2>());
      heights_.push_back(p.z());
    }
  }

  /// Restricts map and path to the storey whose floor has this height.
  void select_storey(double floor) {
    constexpr double kAll = 1e4, kBelow = 0.1, kAbove = 2.5;
    crop_ = Eigen::AlignedBox3d(Eigen::Vector3d(-kAll, -kAll, floor - kBelow),
                                Eigen::Vector3d(kAll, kAll, floor + kAbove));
    std::vector<Eigen::Vector2d> kept;
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (std::abs(heights_[i] - floor) < 0.05) kept.push_back(path_[i]);
    }
    path_ = kept;
  }

  Grid grid(int threads = 0) { return build_grid(frames_, false, threads); }
  Grid grid_of_static_objects() {
    StaticClouds static_clouds(frames_);
    return build_grid(static_clouds, true, 0);
  }

  /// Fraction of free cells among those within a metre of the path.
  double free_fraction(const Grid& grid) const {
    return grid.free_fraction(cells_near_path(grid, 1.0));
  }

  double reached_fraction(const Grid& grid) const {
    const std::set<Grid::Cell> reached = grid.reachable_from(grid.cell_at(path_.front()));
    const auto reachable_count =
        std::count_if(path_.begin(), path_.end(),
                      [&](const Eigen::Vector2d& p) { return reached.count(grid.cell_at(p)) > 0; });
    return static_cast<double>(reachable_count) / static_cast<double>(path_.size());
  }

  /// Fraction of free cells among those within 10 m of the path in which something moved and
  /// nothing stands.
  double free_fraction_of_movers(const Grid& grid, const Grid& static_grid) {
    const std::set<Grid::Cell> near = cells_near_path(grid, 10.0);
    std::set<Grid::Cell> moved;
    for (const KeyFramePose& pose : frames_.poses.poses) {
      const PointCloudPtr cloud = frames_.cloud(pose.index);
      for (std::size_t i = 0; i < cloud->size(); ++i) {
        if (frames_.moving(pose.index)[i] == 0) continue;
        const Eigen::Vector3d p = pose.T_map_base * cloud->points[i].position().cast<double>();
        const Grid::Cell cell = grid.cell_at(p.head<2>());
        const bool stands = static_grid.at(static_grid.cell_at(grid.centre(cell))) != kFree;
        if (near.count(cell) > 0 && !stands) moved.insert(cell);
      }
    }
    EXPECT_GT(moved.size(), 100U);
    return grid.free_fraction(moved);
  }

  /// Fraction of occupied cells among those near the path that something static occupies.
  double kept_fraction(const Grid& grid, const Grid& static_grid) const {
    double occupied = 0.0;
    double kept = 0.0;
    for (const Grid::Cell& cell : cells_near_path(static_grid, 15.0)) {
      if (static_grid.at(cell) != kOccupied) continue;
      occupied += 1.0;
      if (grid.at(grid.cell_at(static_grid.centre(cell))) == kOccupied) kept += 1.0;
    }
    EXPECT_GT(occupied, 100.0);
    return kept / occupied;
  }

 private:
  static simulation::DriveOptions options(const std::string& name, const std::string& lidar,
                                          double end_s) {
    simulation::DriveOptions options;
    options.drive = name;
    options.lidar = lidar;
    options.undistorted = true;
    options.duration = end_s + 1.0;
    return options;
  }

  Grid build_grid(CloudSource& clouds, bool keep_moving, int threads) const {
    const test::TemporaryFolder folder;
    MapConfig config;
    config.threads = threads;
    ProductOptions options;
    options.formats = {"grid"};
    options.p_base_sensor = drive_.mounting().T_base_lidar.translation;
    options.keep_moving = keep_moving;
    options.crop = crop_;
    write_products(frames_.poses, clouds, config, options, folder.path());
    return Grid(folder.path());
  }

  std::set<Grid::Cell> cells_near_path(const Grid& grid, double distance) const {
    std::set<Grid::Cell> cells;
    const int reach = static_cast<int>(std::ceil(distance / grid.size()));
    Eigen::Vector2d last(1e9, 1e9);
    for (const Eigen::Vector2d& p : path_) {
      if ((p - last).norm() < 0.5 * grid.size()) continue;
      last = p;
      const auto [column, row] = grid.cell_at(p);
      for (int dx = -reach; dx <= reach; ++dx) {
        for (int dy = -reach; dy <= reach; ++dy) {
          const Grid::Cell cell(column + dx, row + dy);
          if ((grid.centre(cell) - p).norm() <= distance) cells.insert(cell);
        }
      }
    }
    return cells;
  }

  simulation::Drive drive_;
  test::SimulatedKeyFrames frames_;
  std::vector<Eigen::Vector2d> path_;
  std::vector<double> heights_;
  std::optional<Eigen::AlignedBox3d> crop_;
};

void expect_usable_grid(DriveWithGrid& drive) {
  const Grid grid = drive.grid();
  const Grid static_grid = drive.grid_of_static_objects();
  const double free = drive.free_fraction(grid);
  const double reached = drive.reached_fraction(grid);
  const double movers = drive.free_fraction_of_movers(grid, static_grid);
  const double kept = drive.kept_fraction(grid, static_grid);
  std::printf("path free %.4f, path reached %.4f, movers free %.4f, obstacles kept %.4f\n", free,
              reached, movers, kept);
  EXPECT_GE(free, 0.99);
  EXPECT_EQ(reached, 1.0);
  EXPECT_GE(movers, 0.97);
  EXPECT_GE(kept, 0.98);
}

TEST(SimulatedGrid, TownWithSixtyFourBeams) {
  DriveWithGrid drive("town", "hdl64", 4, 5.0, 20.0);
  expect_usable_grid(drive);
}

TEST(SimulatedGrid, TownWithSixteenBeams) {
  DriveWithGrid drive("town", "vlp16", 1, 5.0, 25.0);
  expect_usable_grid(drive);
  EXPECT_EQ(drive.grid(1).bytes(), drive.grid(3).bytes()) << "for any number of threads";
}

TEST(SimulatedGrid, FigureEightWithSixtyFourBeams) {
  DriveWithGrid drive("figure_eight", "hdl64", 4, 2.0, 15.0);
  expect_usable_grid(drive);
}

TEST(SimulatedGrid, FigureEightWithSixteenBeams) {
  DriveWithGrid drive("figure_eight", "vlp16", 1, 2.0, 25.0);
  expect_usable_grid(drive);
}

/// A grid has one level, which a box selects from the map.
TEST(SimulatedGrid, EachStoreyOfCarPark) {
  for (const double floor : {0.0, 3.0}) {
    DriveWithGrid drive("car_park", "vlp16", 1, 5.0, 90.0);
    drive.select_storey(floor);
    const Grid grid = drive.grid();
    const double free = drive.free_fraction(grid);
    std::printf("storey at %g m: path free %.4f, reached %.4f\n", floor, free,
                drive.reached_fraction(grid));
    EXPECT_GE(free, 0.99) << floor;
    EXPECT_GE(drive.reached_fraction(grid), 0.99) << floor;
  }
}

}  // namespace
}  // namespace lidar_mapping::map
