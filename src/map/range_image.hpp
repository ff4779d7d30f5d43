#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

/// What a sensor saw of a place.
enum class Sight { kUnknown, kSeenThrough, kHit };

/// Nearest and farthest range in each direction, seen from the sensor; 0.4 degrees in azimuth, 0.5
/// in elevation. A place counts as seen through only if all of the 3x3 directions around it are
/// free: a beam one step aside may touch a pole, one step lower the ground in front.
class RangeImage {
 public:
  /// Points in a frame that is parallel to the sensor's, and where the sensor is in it.
  RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor);

  Sight sight_of(const Eigen::Vector3f& p_sensor) const;

 private:
  struct Seen {
    float nearest;
    float farthest;
  };
  struct Pixel {
    Seen own;
    Seen around;  ///< of the 3x3 window
  };
  static bool is_within(const Seen& seen, float nearest, float farthest);
  bool is_hit_around(int column, int row, float nearest, float farthest) const;
  std::size_t at(int column, int row) const;
  void close_window();

  int first_row_ = 0;
  int rows_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace lidar_mapping::map
