// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/simulation/ray_caster.hpp"

namespace lidar_mapping::simulation {
namespace {

constexpr double kFrame = 0.1;  ///< s
constexpr float kReach = 200.0F;

/// Rays from about the origin into the directions around x.
std::vector<Ray> rays_ahead(std::size_t count) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> uniform(-0.4F, 0.4F), time(0.0F, 1.0F);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) {
    ray.origin = {uniform(engine), uniform(engine), uniform(engine)};
    ray.direction = Eigen::Vector3f(1.0F, uniform(engine), uniform(engine)).normalized();
    ray.time = time(engine);
  }
  return rays;
}

/// One large triangle through the point (distance, 0, 0), oblique to the axes.
TriangleMesh oblique_triangle(double distance) {
  TriangleMesh mesh;
  add_triangle(mesh, {distance, 0.0, 300.0}, {distance + 60.0, -300.0, -200.0},
               {distance - 20.0, 300.0, -220.0}, 90);
  return mesh;
}

/// Distance along the ray to the plane of a triangle whose corners were moved by `shift`.
double distance_to(const TriangleMesh& mesh, const Eigen::Vector3d& shift, const Ray& ray) {
  const Eigen::Vector3d a = mesh.vertices[0].cast<double>() + shift;
  const Eigen::Vector3d b = mesh.vertices[1].cast<double>() + shift;
  const Eigen::Vector3d c = mesh.vertices[2].cast<double>() + shift;
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  return normal.dot(a - ray.origin.cast<double>()) / normal.dot(ray.direction.cast<double>());
}

/// The neighbouring floating-point numbers of a value are this far away.
float spacing(double value) {
  const auto rounded = static_cast<float>(value);
  return std::nextafter(rounded, kReach) - rounded;
}

// An approximate reciprocal, which each maker of processors rounds in his own way, moved a third of
// the ranges to the next floating-point number or further.
TEST(RayCaster, RoundsRangesOnlyOnce) {
  World world;
  world.fixed = oblique_triangle(30.0);
  const std::vector<Ray> rays = rays_ahead(1000);
  std::vector<Hit> hits;
  RayCaster(world).cast(rays, 0.0, kFrame, 0.1F, kReach, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double expected = distance_to(world.fixed, Eigen::Vector3d::Zero(), rays[i]);
    EXPECT_NEAR(hits[i].range, expected, 0.501 * spacing(expected)) << i;
    EXPECT_FALSE(hits[i].moving);
    EXPECT_EQ(hits[i].reflectivity, 90);
  }
}

TEST(RayCaster, MeasuresMoversWhereTheyAreAtTheTimeOfTheRay) {
  const Eigen::Vector3d velocity(15.0, 3.0, -1.0);  // m/s
  World world;
  add_block(world.fixed, {-20.0, -1.0, -1.0}, {-19.0, 1.0, 1.0}, 10);  // behind the rays
  Mover mover;
  mover.step_s = kFrame;
  for (int i = 0; i < 3; ++i) mover.T_map_shape.emplace_back();
  for (int i = 0; i < 3; ++i) mover.T_map_shape[i].translation = i * kFrame * velocity;
  world.add(oblique_triangle(30.0), mover);
  const std::vector<Ray> rays = rays_ahead(1000);
  std::vector<Hit> hits;
  RayCaster(world).cast(rays, 0.0, kFrame, 0.1F, kReach, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d shift = rays[i].time * kFrame * velocity;
    const double expected = distance_to(world.shapes[0], shift, rays[i]);
    EXPECT_NEAR(hits[i].range, expected, 0.501 * spacing(expected)) << i;
    EXPECT_TRUE(hits[i].moving);
  }
}

}  // namespace
}  // namespace lidar_mapping::simulation
