#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/loop_closing/surface.hpp"

#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

TEST(SurfaceCloud, HasNormalsOnWallsAndNoneInFoliage) {
  std::vector<Eigen::Vector3f> points;
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> coordinate(0.0F, 5.0F);
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(coordinate(generator), 0.0F, coordinate(generator));
    points.emplace_back(coordinate(generator), 20.0F + coordinate(generator),
                        coordinate(generator));
  }
  const SurfaceCloud surface(points);
  const auto& placed = surface.tree().points();
  int on_wall = 0;
  int in_foliage = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const bool wall = placed[i].y() < 10.0F;
    if (wall) on_wall += std::abs(surface.normal(i).y()) > 0.999F;
    if (!wall) in_foliage += !surface.normal(i).isZero();
  }
  EXPECT_EQ(on_wall, 2000);
  EXPECT_LT(in_foliage, 300);
}

TEST(AboveGround, FollowsASlope) {
  std::vector<Eigen::Vector3f> points;
  for (float x = -30.0F; x < 30.0F; x += 0.5F) points.emplace_back(x, 0.0F, 0.1F * x);
  const std::size_t ground = points.size();
  points.emplace_back(20.0F, 0.0F, 2.0F + 2.0F);
  const auto above = above_ground(points);
  EXPECT_TRUE(above.back());
  for (std::size_t i = 0; i < ground; ++i) EXPECT_FALSE(above[i]) << i;
}

TEST(Positions, LeaveOutWhatIsNotFinite) {
  PointCloud cloud;
  cloud.points = {{1.0F, 2.0F, 3.0F, 0.0F}, {std::nanf(""), 0.0F, 0.0F, 0.0F}};
  EXPECT_EQ(positions(cloud).size(), 1U);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
