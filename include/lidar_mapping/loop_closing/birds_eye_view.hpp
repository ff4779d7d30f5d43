// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::loop_closing {

/// Bird's-eye view of a key frame: which of 120 x 120 cells of 1 m around base_link hold points
/// above the ground. 1.8 kB.
class BirdsEyeView {
 public:
  static constexpr int kWidth = 120;  ///< number of cells of 1 m along x and along y; chosen

  BirdsEyeView() = default;
  /// The view of those points (in base_link, m) whose entry in `above_ground` is true.
  BirdsEyeView(const std::vector<Eigen::Vector3f>& points, const std::vector<bool>& above_ground);

  /// Centres of the occupied cells, m.
  std::vector<Eigen::Vector2f> cells() const;
  /// Number of occupied cells.
  std::size_t count() const { return occupied_.count(); }

 private:
  std::bitset<kWidth * kWidth> occupied_;
};

/// A pose (m, rad) on the ground plane of a view: a match of views tells neither height nor tilt.
Pose planar_pose(const Eigen::Vector2d& translation, double yaw);

/// The result of matching two views: a horizontal translation and its score.
struct ViewMatch {
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();  ///< of the source in the target, m
  /// Normalised correlation: 1 of a view with itself, 0 if a view is empty. It can exceed 1,
  /// because cells beside those of the target count, too: of a single cell with the nine around it,
  /// it is 5/3.
  double score = 0.0;
};

/// Finds the horizontal position of other views in a target view by correlation on the 1 m grid.
class ViewCorrelator {
 public:
  /// Prepares the weights of the target's cells.
  explicit ViewCorrelator(const BirdsEyeView& target);
  /// The translation with the best score, at most 15 m along x and y. `source` are centres of cells
  /// (m), which are rotated by `yaw` (rad) first.
  ViewMatch match(const std::vector<Eigen::Vector2f>& source, double yaw) const;

 private:
  std::vector<std::uint8_t> weights_;  ///< of the target's cells, with a margin of zeros
  double norm_ = 0.0;
};

}  // namespace lidar_mapping::loop_closing
