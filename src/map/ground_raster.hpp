// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/local_ground.hpp"

namespace lidar_mapping::map {

/// Height of the ground in columns of 0.6 m, also where no point lies: up to 3 m from where it is
/// known, as the surroundings have it.
class GroundRaster {
 public:
  static constexpr float kUnknown = moving_objects::LowestPoints::kNone;
  /// The ground there depends on points that are this near, m.
  static constexpr float kReach = 6.0F;

  /// The points and their ground, in the map frame.
  GroundRaster(const moving_objects::PlacedPoints& points, const moving_objects::GroundArea& area,
               moving_objects::LocalGround& ground);

  /// Number of the column or row of a coordinate of the map frame, m.
  static int cell_of(double coordinate);
  /// m in the map frame, by cell_of() of x and y; kUnknown where nobody can tell.
  float at(int column, int row) const {
    const std::uint32_t number = rectangle_.number_of({column, row});
    return number == moving_objects::CellArea::kOutside ? kUnknown : heights_[number];
  }
  /// Of what is known, m; the lowest is above the highest where nothing is.
  float lowest() const { return lowest_; }
  float highest() const { return highest_; }

 private:
  void fill_holes();
  /// From the eight columns around, or kUnknown.
  float guess(std::size_t number) const;
  void find_limits();

  moving_objects::CellArea rectangle_;
  std::vector<float> heights_;
  float lowest_ = kUnknown;
  float highest_ = -kUnknown;
};

}  // namespace lidar_mapping::map
