#pragma once

#include <optional>
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
  /// Points in the frame of the sensor.
  explicit RangeImage(const std::vector<Eigen::Vector3f>& points);

  Sight sight_of(const Eigen::Vector3f& p_sensor) const;

 private:
  struct Pixel {
    float nearest;
    float farthest;
  };
  struct Direction {
    int column = 0;
    int row = 0;  ///< may lie outside of the image
    float range = 0.0F;
  };
  static Direction direction_of(const Eigen::Vector3f& p_sensor);
  std::size_t at(int column, int row) const;
  void close_window();

  int first_row_ = 0;
  int rows_ = 0;
  std::vector<Pixel> pixels_;
  std::vector<float> nearest_around_;  ///< minimum over the 3x3 window
};

}  // namespace lidar_mapping::map
