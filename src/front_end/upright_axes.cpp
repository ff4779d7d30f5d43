#include "upright_axes.hpp"

#include <cmath>
#include <cstddef>

#include "lidar_mapping/common/units.hpp"

#include "scan_sampler.hpp"
#include "upright_map.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A LiDAR that leans by less is followed as well in its own axes (tested with 20 degrees).
constexpr double kLeaning = 20.0 * kRadPerDeg;
/// So many points are looked at, from the vehicle on to where rings still lie close together.
constexpr std::size_t kLookedAt = 4000;
constexpr float kNearest = 2.0F;    // m
constexpr float kFarthest = 25.0F;  // m
/// With z up the ground stands nowhere above itself. By a wrong axis that is 30 degrees off, two to
/// three times as many points of a simulated street do.
constexpr double kClearlyFewer = 0.8;

/// How many of the points stand above others where `R_level_sensor` makes z up.
double standing(const PointCloud& cloud, const Eigen::Quaterniond& R_level_sensor) {
  const Eigen::Matrix3f R = R_level_sensor.toRotationMatrix().cast<float>();
  const std::size_t step = cloud.size() / kLookedAt + 1;
  SampledPoints points;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3f p = R * cloud.points[i].position();
    // Written so that NaN fails.
    if (!(p.norm() > kNearest && p.norm() < kFarthest)) continue;
    points.x.push_back(p.x());
    points.y.push_back(p.y());
    points.z.push_back(p.z());
    points.s.push_back(0.0F);
  }
  return static_cast<double>(upright_points(points).size());
}

}  // namespace

Eigen::Quaterniond upright_axes(const PointCloud& cloud, const Pose& T_base_sensor) {
  const Eigen::Quaterniond own = Eigen::Quaterniond::Identity();
  const Eigen::Vector3d up = T_base_sensor.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  // Upside down it is upright all the same.
  if (std::abs(up.z()) > std::cos(kLeaning)) return own;
  const Eigen::Quaterniond R_sensor_level =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up);
  const bool is_level =
      standing(cloud, R_sensor_level.conjugate()) < kClearlyFewer * standing(cloud, own);
  return is_level ? R_sensor_level : own;
}

}  // namespace lidar_mapping::front_end
