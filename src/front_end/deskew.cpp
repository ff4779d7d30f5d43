#include "lidar_mapping/front_end/deskew.hpp"

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kGrain = 16384;

}  // namespace

PointCloud deskewed(const PointCloud& cloud, const Vector6d& twist, int threads) {
  if (!cloud.has_times()) return cloud;
  const Eigen::Vector3f v = twist.head<3>().cast<float>();
  const Eigen::Vector3f w = twist.tail<3>().cast<float>();
  PointCloud result;
  result.points.resize(cloud.size());
  parallel_chunks(cloud.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // exp(s * twist) to second order: within one turn the third is below a millimetre.
      const Point& point = cloud.points[i];
      const float s = cloud.times[i];
      const Eigen::Vector3f velocity = v + w.cross(point.position());
      const Eigen::Vector3f moved =
          point.position() + s * (velocity + (0.5F * s) * w.cross(velocity));
      result.points[i] = {moved.x(), moved.y(), moved.z(), point.intensity};
    }
  });
  return result;
}

}  // namespace lidar_mapping::front_end
