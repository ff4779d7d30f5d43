// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/front_end/deskew.hpp"

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::front_end {
namespace {

// Points, 256 kB. Chosen: smaller shares wake threads more often, larger ones leave some idle.
constexpr std::size_t kGrain = 16384;

/// exp(s * twist) to second order: within one turn of the sensor the third-order term is below a
/// millimetre. It is written as p + s ((v + W p) + s (W v + W^2 p + a + A p) / 2), where a and A
/// belong to the acceleration. The fourth component, the intensity, is not changed: so a point is
/// one vector register.
class Deskewer {
 public:
  Deskewer(const Vector6d& twist, const Vector6d& acceleration) {
    const Eigen::Matrix3d W = skew(twist.tail<3>());
    velocity_.topLeftCorner<3, 3>() = W.cast<float>();
    velocity_.topRightCorner<3, 1>() = twist.head<3>().cast<float>();
    acceleration_.topRows<3>() = (0.5 * W).cast<float>() * velocity_.topRows<3>();
    acceleration_.topLeftCorner<3, 3>() += (0.5 * skew(acceleration.tail<3>())).cast<float>();
    acceleration_.topRightCorner<3, 1>() += (0.5 * acceleration.head<3>()).cast<float>();
  }

  Point operator()(const Point& point, float s) const {
    const Eigen::Vector4f p(point.x, point.y, point.z, point.intensity);
    const Eigen::Vector4f moved = p + s * (at(velocity_, point) + s * at(acceleration_, point));
    return {moved[0], moved[1], moved[2], moved[3]};
  }

 private:
  static Eigen::Vector4f at(const Eigen::Matrix4f& field, const Point& p) {
    return field.col(3) + field.col(0) * p.x + field.col(1) * p.y + field.col(2) * p.z;
  }

  Eigen::Matrix4f velocity_ = Eigen::Matrix4f::Zero();
  Eigen::Matrix4f acceleration_ = Eigen::Matrix4f::Zero();
};

}  // namespace

PointCloud deskewed(PointCloud cloud, const Vector6d& twist, const Vector6d& acceleration,
                    int threads) {
  if (!cloud.has_times()) return cloud;
  const Deskewer deskew(twist, acceleration);
  parallel_chunks(cloud.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      cloud.points[i] = deskew(cloud.points[i], cloud.times[i]);
    }
  });
  cloud.times = {};
  return cloud;
}

}  // namespace lidar_mapping::front_end
