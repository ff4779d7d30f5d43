#pragma once

#include <vector>

#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::map {

constexpr int kRangeImageColumns = 900;

/// What a sensor saw of a place.
enum class Sight { kUnknown, kSeenThrough, kHit };

/// Points seen from a sensor, one coordinate after the other, so that they are projected in
/// vectors.
struct SensorPoints {
  std::vector<float> x, y, z;

  std::size_t size() const { return x.size(); }
  void resize(std::size_t size);
};

/// Where they are seen in any range image: a column, a row that may lie outside, and a range each.
struct Directions {
  std::vector<int> columns, rows;
  std::vector<float> ranges;

  void project(const SensorPoints& points);
};

/// Nearest and farthest range in each direction, seen from the sensor; 0.4 degrees in azimuth, 0.5
/// in elevation. A place counts as seen through only if all of the 3x3 directions around it are
/// free: a beam one step aside may touch a pole, one step lower the ground in front.
class RangeImage {
 public:
  /// Points in a frame that is parallel to the sensor's, and where the sensor is in it.
  RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor);

  /// What it saw of the places.
  void look(const Directions& directions, std::vector<Sight>& sights) const;

 private:
  struct Seen {
    float nearest;
    float farthest;
  };
  struct Pixel {
    Seen own;
    Seen around;  ///< of the 3x3 window
  };
  /// What lies between the two was not hit: a pixel on an edge sees a thing and a wall behind it.
  static bool is_within(const Seen& seen, float nearest, float farthest) {
    return (seen.nearest >= nearest && seen.nearest <= farthest) ||
           (seen.farthest >= nearest && seen.farthest <= farthest);
  }
  Sight sight_of(int column, int row, float range) const;
  bool is_hit_around(int column, int row, float nearest, float farthest) const;
  static std::size_t at(int column, int row) {
    return static_cast<std::size_t>(row) * kRangeImageColumns + static_cast<std::size_t>(column);
  }
  void close_window();

  int first_row_ = 0;
  int rows_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace lidar_mapping::map
