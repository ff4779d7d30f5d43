// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/birds_eye_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr int kHalfWidth = BirdsEyeView::kWidth / 2;  // cells, by definition
// Cells; chosen: the largest distance at which a descriptor still finds the place.
constexpr int kMaxShift = 15;
constexpr int kShifts = 2 * kMaxShift + 1;  // along each axis: twice kMaxShift, and zero
constexpr int kMargin = kMaxShift + 1;  // cells around the target, so that no shift leaves the grid
// Cells along an edge, by definition: the view and its margins.
constexpr int kGrid = BirdsEyeView::kWidth + 2 * kMargin;
// Weight of an occupied cell; its neighbours have half of it, the least whole number. Chosen: a
// point near an edge of its cell also fits the next cell.
constexpr std::uint8_t kOccupiedWeight = 2;

constexpr int kLanes = 16;  // bytes in a register of 128 bits, which every processor has
using Lanes = std::uint8_t __attribute__((vector_size(kLanes)));
constexpr int kRowLanes = 32;  // for the shifts along x: twice kLanes; the last one is unused
static_assert(kRowLanes == 2 * kLanes && kRowLanes > kShifts);

inline Lanes load(const std::uint8_t* values) {
  Lanes lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}

/// Sums of weights for all shifts along x.
using RowSums = std::array<std::uint16_t, kRowLanes>;

/// `row` holds the weights for one shift along y; `first_cells` are the positions in it at which
/// the shifts of each source cell begin.
RowSums row_sums(const std::vector<int>& first_cells, const std::uint8_t* row) {
  constexpr std::size_t kMaxSummands = 255 / kOccupiedWeight;  // so that their sum fits into a byte
  RowSums sums{};
  for (std::size_t begin = 0; begin < first_cells.size(); begin += kMaxSummands) {
    const std::size_t end = std::min(begin + kMaxSummands, first_cells.size());
    Lanes left = {};
    Lanes right = {};
    for (std::size_t i = begin; i < end; ++i) {
      left += load(row + first_cells[i]);
      right += load(row + first_cells[i] + kLanes);
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      sums[lane] = static_cast<std::uint16_t>(sums[lane] + left[lane]);
      sums[kLanes + lane] = static_cast<std::uint16_t>(sums[kLanes + lane] + right[lane]);
    }
  }
  return sums;
}

/// For each cell of the source, rotated by `yaw`: the number of the target's cell below it at the
/// smallest shifts along both axes.
std::vector<int> first_cells_of(const std::vector<Eigen::Vector2f>& source, double yaw) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  std::vector<int> first_cells;
  first_cells.reserve(source.size());
  for (const auto& cell : source) {
    const Eigen::Vector2f rotated = R * cell;
    const int x = floor_to_int(rotated.x()) - kMaxShift + kGrid / 2;
    const int y = floor_to_int(rotated.y()) - kMaxShift + kGrid / 2;
    first_cells.push_back(y * kGrid + x);
  }
  return first_cells;
}

struct Peak {
  int sum = -1;
  int x = 0;
  int y = 0;
};

}  // namespace

BirdsEyeView::BirdsEyeView(const std::vector<Eigen::Vector3f>& points,
                           const std::vector<bool>& above_ground) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float range = points[i].head<2>().norm();
    if (!above_ground[i] || range >= static_cast<float>(kHalfWidth)) continue;
    occupied_.set((floor_to_int(points[i].y()) + kHalfWidth) * kWidth +
                  floor_to_int(points[i].x()) + kHalfWidth);
  }
}

std::vector<Eigen::Vector2f> BirdsEyeView::cells() const {
  std::vector<Eigen::Vector2f> result;
  for (int i = 0; i < kWidth * kWidth; ++i) {
    if (!occupied_[i]) continue;
    result.emplace_back(static_cast<float>(i % kWidth - kHalfWidth) + 0.5F,
                        static_cast<float>(i / kWidth - kHalfWidth) + 0.5F);
  }
  return result;
}

Pose planar_pose(const Eigen::Vector2d& translation, double yaw) {
  Pose pose;
  pose.translation << translation, 0.0;
  pose.rotation = rotation_about_z(yaw);
  return pose;
}

ViewCorrelator::ViewCorrelator(const BirdsEyeView& target) : weights_(kGrid * kGrid + kLanes, 0) {
  const auto cells = target.cells();
  for (const auto& cell : cells) {
    const int x = floor_to_int(cell.x()) + kGrid / 2;
    const int y = floor_to_int(cell.y()) + kGrid / 2;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        std::uint8_t& weight = weights_[(y + dy) * kGrid + x + dx];
        weight = std::max<std::uint8_t>(weight,
                                        dx == 0 && dy == 0 ? kOccupiedWeight : kOccupiedWeight / 2);
      }
    }
  }
  norm_ = std::sqrt(static_cast<double>(cells.size()));
}

ViewMatch ViewCorrelator::match(const std::vector<Eigen::Vector2f>& source, double yaw) const {
  if (source.empty() || norm_ == 0.0) return {};
  const std::vector<int> first_cells = first_cells_of(source, yaw);
  Peak peak;
  for (int y = 0; y < kShifts; ++y) {
    const RowSums sums = row_sums(first_cells, &weights_[y * kGrid]);
    for (int x = 0; x < kShifts; ++x) {
      if (sums[x] > peak.sum) peak = {sums[x], x, y};
    }
  }
  ViewMatch match;
  match.translation = {peak.x - kMaxShift, peak.y - kMaxShift};
  match.score =
      peak.sum / (kOccupiedWeight * norm_ * std::sqrt(static_cast<double>(source.size())));
  return match;
}

}  // namespace lidar_mapping::loop_closing
