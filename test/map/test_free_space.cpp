// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "grid/free_space.hpp"
#include "memory_clouds.hpp"

namespace lidar_mapping::map {
namespace {

using Cell = std::pair<int, int>;  // column, row

const Eigen::Vector3d kSensor(0.0, 0.0, 1.5);  // in base_link

/// Level ground from zero to `length` along x and to `width` along y, m.
PointCloud level_ground(double length, double width, float z = 0.0F) {
  PointCloud cloud;
  for (double x = 0.05; x < length; x += 0.2) {
    for (double y = 0.05; y < width; y += 0.2) {
      cloud.points.push_back({static_cast<float>(x), static_cast<float>(y), z, 0.0F});
    }
  }
  return cloud;
}

/// Rays over level ground.
class Scene {
 public:
  explicit Scene(double length = 12.0, double width = 8.0, float z = 0.0F)
      : ground_points_(level_ground(length, width, z)),
        points_(ground_points_, Pose()),
        area_(points_),
        frame_(ground_points_, 0.2),
        raster_(raster()) {}

  /// Adds a key frame with the LiDAR at this place, and the ends of its rays; all in the map, m.
  void add(const Eigen::Vector3d& lidar, const std::vector<Eigen::Vector3d>& ends) {
    Pose T_map_base{exp_so3({0.0, 0.0, 0.4}), Eigen::Vector3d::Zero()};
    T_map_base.translation = lidar - T_map_base.rotation * kSensor;
    std::vector<Point> points;
    for (const Eigen::Vector3d& end : ends) {
      const Eigen::Vector3f p = (T_map_base.inverse() * end).cast<float>();
      points.push_back({p.x(), p.y(), p.z(), 0.0F});
    }
    const auto index = static_cast<KeyFrameIndex>(poses_.poses.size());
    clouds_.clouds[index] = cloud_of(std::move(points));
    poses_.poses.push_back({index, Stamp{index}, T_map_base});
  }
  void add_without_cloud() { poses_.poses.push_back({4000, 0, Pose()}); }
  void reverse() { std::reverse(poses_.poses.begin(), poses_.poses.end()); }

  GridBlock whole() const { return {0, 0, frame_.columns, frame_.rows}; }
  std::set<Cell> passed() { return passed(whole()); }
  std::set<Cell> passed(const GridBlock& block, int threads = 1) {
    GridOptions options;
    options.threads = threads;
    FreeSpace space(frame_, block, raster_, options);
    space.carve({poses_, clouds_, kSensor});
    std::set<Cell> cells;
    for (int row = block.row; row < block.row + block.rows; ++row) {
      for (int column = block.column; column < block.column + block.columns; ++column) {
        if (space.passed(block.index_of(column, row))) cells.insert({column, row});
      }
    }
    return cells;
  }
  Cell cell_at(const Eigen::Vector3d& p) const {
    return {static_cast<int>(std::floor((p.x() - frame_.x_min) / frame_.cell)),
            static_cast<int>(std::floor((p.y() - frame_.y_min) / frame_.cell))};
  }
  bool is_inside(const Cell& cell) const { return whole().contains(cell.first, cell.second); }

 private:
  GroundRaster raster() {
    moving_objects::LocalGround ground(area_);
    ground.add(moving_objects::ground_columns(points_));
    return {points_, area_, ground};
  }

  PointCloud ground_points_;
  moving_objects::TransformedPoints points_;
  moving_objects::GroundArea area_;
  GridFrame frame_;
  GroundRaster raster_;
  MemoryClouds clouds_;
  KeyFramePoses poses_;
};

/// Cells that a ray passes between these heights by many points on it.
std::set<Cell> sampled(const Scene& scene, const Eigen::Vector3d& begin, const Eigen::Vector3d& end,
                       double lowest = -0.3, double highest = 2.0) {
  constexpr int kSamples = 20'000;
  std::set<Cell> cells;
  for (int i = 0; i <= kSamples; ++i) {
    const Eigen::Vector3d p = begin + (end - begin) * i / kSamples;
    if (p.z() <= lowest || p.z() > highest) continue;
    const Cell cell = scene.cell_at(p);
    if (scene.is_inside(cell)) cells.insert(cell);
  }
  return cells;
}

std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> random_rays(std::size_t count) {
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> x(-3.0, 15.0), y(-3.0, 11.0), z(0.2, 1.8);
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> rays;
  while (rays.size() < count) {
    const double values[6] = {x(engine), y(engine), z(engine), x(engine), y(engine), z(engine)};
    rays.push_back({{values[0], values[1], values[2]}, {values[3], values[4], values[5]}});
  }
  return rays;
}

// In any direction, from and to places inside and outside of the grid.
TEST(FreeSpace, IsEveryCellAlongARay) {
  for (const auto& [begin, end] : random_rays(60)) {
    Scene scene;
    scene.add(begin, {end});
    const std::set<Cell> passed = scene.passed();
    const std::set<Cell> expected = sampled(scene, begin, end);
    // The samples miss corners that the ray cuts by less than a millimetre.
    std::vector<Cell> missed, invented;
    std::set_difference(expected.begin(), expected.end(), passed.begin(), passed.end(),
                        std::back_inserter(missed));
    std::set_difference(passed.begin(), passed.end(), expected.begin(), expected.end(),
                        std::back_inserter(invented));
    EXPECT_LE(missed.size() + invented.size(), 1U)
        << begin.transpose() << " to " << end.transpose();
  }
}

TEST(FreeSpace, MayLieAlongTheAxes) {
  const Eigen::Vector3d middle(6.03, 4.03, 1.0);
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(3.0, 0.0, 0.0), Eigen::Vector3d(-3.0, 0.0, 0.0),
        Eigen::Vector3d(0.0, 3.0, 0.0), Eigen::Vector3d(0.0, -3.0, 0.0),
        Eigen::Vector3d(0.0, 0.0, -0.9)}) {
    Scene scene;
    scene.add(middle, {middle + way});
    const std::set<Cell> passed = scene.passed();
    EXPECT_NEAR(static_cast<double>(passed.size()), way.head<2>().norm() / 0.2 + 1.0, 1.0)
        << way.transpose();
    EXPECT_EQ(passed.count(scene.cell_at(middle)), 1U) << way.transpose();
  }
}

// Above the height of the vehicle there may be a branch, and under it a car.
TEST(FreeSpace, EndsAboveTheVehicle) {
  for (const float ground : {0.0F, 40.0F}) {
    const double z = static_cast<double>(ground);
    Scene scene(12.0, 8.0, ground);
    scene.add({1.0, 4.03, z + 2.5}, {{11.0, 4.03, z + 2.5}});
    EXPECT_TRUE(scene.passed().empty());
    scene.add({1.0, 4.03, z + 4.0}, {{11.0, 4.03, z + 0.0}});  // at 2 m above the ground at x = 6
    const std::set<Cell> passed = scene.passed();
    ASSERT_FALSE(passed.empty());
    EXPECT_NEAR(passed.begin()->first, scene.cell_at({6.0, 4.0, 0.0}).first, 1);
    EXPECT_EQ(passed.rbegin()->first, scene.cell_at({11.0, 4.0, 0.0}).first);
  }
}

// Mirrors of glass and of puddles show points below the ground.
TEST(FreeSpace, EndsBelowTheGround) {
  Scene scene;
  scene.add({1.0, 4.03, 1.5}, {{11.0, 4.03, -3.5}});  // at 0.3 m below the ground at x = 4.6
  const std::set<Cell> passed = scene.passed();
  ASSERT_FALSE(passed.empty());
  EXPECT_NEAR(passed.rbegin()->first, scene.cell_at({4.6, 4.0, 0.0}).first, 1);
}

TEST(FreeSpace, EndsFiftyMetresFromTheLidar) {
  Scene scene(80.0, 4.0);
  scene.add({2.0, 2.03, 1.0}, {{78.0, 2.03, 1.0}});
  const std::set<Cell> passed = scene.passed();
  ASSERT_FALSE(passed.empty());
  EXPECT_NEAR(passed.rbegin()->first, scene.cell_at({52.0, 2.0, 0.0}).first, 1);
}

TEST(FreeSpace, IsNotWhereTheGroundIsUnknown) {
  Scene scene(4.0, 4.0);
  scene.add({1.0, 2.03, 1.0}, {{15.0, 2.03, 1.0}});
  EXPECT_FALSE(scene.passed().empty());
  // A block beside all ground, farther than its height is extended.
  EXPECT_TRUE(scene.passed({60, 0, 20, 20}).empty());
}

TEST(FreeSpace, LeavesOutWhatIsNoPoint) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Scene scene;
  scene.add_without_cloud();
  scene.add({1.0, 4.0, 1.0}, {});
  scene.add({1.0, 4.0, 1.0}, {{kNaN, 4.0, 1.0}, {5.0, 4.0, kNaN}});
  EXPECT_TRUE(scene.passed().empty());
}

TEST(FreeSpace, DependsNeitherOnTheOrderOfKeyFramesNorOnThreads) {
  Scene scene;
  for (const auto& [begin, end] : random_rays(80)) scene.add(begin, {end, begin, 0.5 * end});
  const std::set<Cell> passed = scene.passed(scene.whole(), 1);
  EXPECT_GT(passed.size(), 300U);
  EXPECT_EQ(scene.passed(scene.whole(), 3), passed);
  scene.reverse();
  EXPECT_EQ(scene.passed(scene.whole(), 1), passed);
}

// The grid of a town is computed block by block.
TEST(FreeSpace, OfBlocksIsThatOfTheWholeGrid) {
  Scene scene;
  for (const auto& [begin, end] : random_rays(40)) scene.add(begin, {end});
  std::set<Cell> of_blocks;
  const GridBlock whole = scene.whole();
  for (int column = 0; column < whole.columns; column += 17) {
    for (int row = 0; row < whole.rows; row += 13) {
      const GridBlock block{column, row, std::min(17, whole.columns - column),
                            std::min(13, whole.rows - row)};
      const std::set<Cell> own = scene.passed(block);
      of_blocks.insert(own.begin(), own.end());
    }
  }
  EXPECT_EQ(of_blocks, scene.passed());
}

}  // namespace
}  // namespace lidar_mapping::map
