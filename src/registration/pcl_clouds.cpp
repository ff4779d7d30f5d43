#include "pcl_clouds.hpp"

#include <cmath>

namespace lidar_mapping::registration {

PclCloud::Ptr to_pcl(const PointCloud& cloud) {
  PclCloud::Ptr result(new PclCloud);
  result->reserve(cloud.size());
  for (const Point& p : cloud.points) {
    if (std::isfinite(p.x + p.y + p.z)) result->push_back(pcl::PointXYZ(p.x, p.y, p.z));
  }
  return result;
}

}  // namespace lidar_mapping::registration
