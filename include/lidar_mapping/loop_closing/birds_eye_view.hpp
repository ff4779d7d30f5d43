// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::loop_closing {

/// What stands above the ground around a key frame, seen from above: 120 x 120 cells of 1 m around
/// base_link, 1.8 kB.
class BirdsEyeView {
 public:
  static constexpr int kWidth = 120;

  BirdsEyeView() = default;
  /// Of those points (in base_link) that are marked.
  BirdsEyeView(const std::vector<Eigen::Vector3f>& points, const std::vector<bool>& above_ground);

  /// Centres of the occupied cells, m.
  std::vector<Eigen::Vector2f> cells() const;
  std::size_t count() const { return occupied_.count(); }

 private:
  std::bitset<kWidth * kWidth> occupied_;
};

/// A horizontal shift and how well it puts one view onto another.
struct ViewMatch {
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();  ///< m
  double score = 0.0;  ///< correlation, 0 to 1; 0 if a view is empty
};

/// Finds the horizontal position of other views in one view by correlation on the 1 m grid.
class ViewCorrelator {
 public:
  explicit ViewCorrelator(const BirdsEyeView& target);
  /// The best shift of the cells `source`, turned by `yaw` (rad), of at most 15 m along x and y.
  ViewMatch match(const std::vector<Eigen::Vector2f>& source, double yaw) const;

 private:
  std::vector<std::uint8_t> weights_;  ///< of the target's cells, with a rim of zeros
  double norm_ = 0.0;
};

}  // namespace lidar_mapping::loop_closing
