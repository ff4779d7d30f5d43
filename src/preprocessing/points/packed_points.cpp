// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/packed_points.hpp"

#include <cstring>

namespace lidar_mapping::preprocessing {

void read_points(const PackedPoints& packed, PointCloud& cloud) {
  const unsigned char* from = packed.first;
  for (Point& point : cloud.points) {
    std::memcpy(&point, from, sizeof(Point));  // one load and store of a whole register
    std::memcpy(&point.intensity, from + packed.intensity, sizeof(float));
    from += packed.step;
  }
}

}  // namespace lidar_mapping::preprocessing
