// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "lidar_mapping/moving_objects/local_ground.hpp"

namespace lidar_mapping::map {

/// Height of the ground in columns of 0.6 m. Columns without points take it from their neighbours,
/// up to 3 m from known ground.
class GroundRaster {
 public:
  static constexpr float kUnknown = moving_objects::LowestPoints::kNone;
  /// The ground at a location depends on points within this distance, m. By geometry: the extension
  /// (3 m) and the neighbourhood of a column (two columns of 0.6 m on each side), rounded up.
  static constexpr float kSupportRadius = 6.0F;

  /// Builds the raster from points and their ground, both in the map frame.
  GroundRaster(const moving_objects::TransformedPoints& points,
               const moving_objects::GroundArea& area, moving_objects::LocalGround& ground);

  /// Column or row of a coordinate of the map frame (m).
  static int cell_of(double coordinate);
  /// Height of the ground, m in the map frame; column and row are cell_of() of x and y. kUnknown
  /// where no ground is known.
  float at(int column, int row) const {
    const std::uint32_t index = rectangle_.index_of({column, row});
    return index == moving_objects::CellRectangle::kOutside ? kUnknown : heights_[index];
  }
  /// Lowest known height, m; above highest() if none is known.
  float lowest() const { return lowest_; }
  /// Highest known height, m.
  float highest() const { return highest_; }

 private:
  void fill_holes();
  /// Height from the eight neighbouring columns, or kUnknown.
  float extrapolated_height(std::size_t index) const;
  void update_height_range();

  moving_objects::CellRectangle rectangle_;
  std::vector<float> heights_;
  float lowest_ = kUnknown;
  float highest_ = -kUnknown;
};

}  // namespace lidar_mapping::map
