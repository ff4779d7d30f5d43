#include "lidar_mapping/front_end/deskew.hpp"

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::front_end {
namespace {

constexpr std::size_t kGrain = 16384;

/// exp(s * twist) to second order: within one turn the third is below a millimetre.
class Deskewer {
 public:
  explicit Deskewer(const Vector6d& twist)
      : v_(twist.head<3>().cast<float>()), w_(twist.tail<3>().cast<float>()) {}

  Point operator()(const Point& point, float s) const {
    const Eigen::Vector3f p = point.position();
    const Eigen::Vector3f velocity = v_ + w_.cross(p);
    const Eigen::Vector3f moved = p + s * (velocity + (0.5F * s) * w_.cross(velocity));
    return {moved.x(), moved.y(), moved.z(), point.intensity};
  }

 private:
  Eigen::Vector3f v_;
  Eigen::Vector3f w_;
};

}  // namespace

PointCloud deskewed(const PointCloud& cloud, const Vector6d& twist, int threads) {
  if (!cloud.has_times()) return cloud;
  const Deskewer deskew(twist);
  PointCloud result;
  result.points.resize(cloud.size());
  parallel_chunks(cloud.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      result.points[i] = deskew(cloud.points[i], cloud.times[i]);
    }
  });
  return result;
}

PointCloud deskewed(const PointCloud& cloud, const std::vector<std::uint32_t>& indices,
                    const Vector6d& twist) {
  const Deskewer deskew(twist);
  PointCloud result;
  result.points.reserve(indices.size());
  for (const std::uint32_t i : indices) {
    result.points.push_back(cloud.has_times() ? deskew(cloud.points[i], cloud.times[i])
                                              : cloud.points[i]);
  }
  return result;
}

}  // namespace lidar_mapping::front_end
