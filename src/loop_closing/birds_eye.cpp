// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/birds_eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace lidar_mapping::loop_closing {

namespace {

constexpr int kHalf = BirdsEye::kWidth / 2;
constexpr int kReach = 15;  // cells
constexpr int kShifts = 2 * kReach + 1;
constexpr int kRim = kReach + 1;  // cells around the target, so that no shift leaves the grid
constexpr int kGrid = BirdsEye::kWidth + 2 * kRim;
constexpr std::uint8_t kFull = 2;  // an occupied cell; its neighbours count half

int cell_index(float coordinate) { return static_cast<int>(std::floor(coordinate)); }

constexpr int kLanes = 16;
using Lanes = std::uint8_t __attribute__((vector_size(kLanes)));
constexpr int kRow = 32;  // lanes for the shifts along x; the last one is to spare
static_assert(kRow == 2 * kLanes && kRow > kShifts);

inline Lanes load(const std::uint8_t* values) {
  Lanes lanes;
  std::memcpy(&lanes, values, sizeof(lanes));
  return lanes;
}

/// Sums of weights for all shifts along x.
using RowSums = std::array<std::uint16_t, kRow>;

/// `row`: the weights for one shift along y; `corners`: where in them those of each cell begin.
RowSums row_sums(const std::vector<int>& corners, const std::uint8_t* row) {
  constexpr std::size_t kMost = 255 / kFull;  // summands that a byte can take
  RowSums sums{};
  for (std::size_t begin = 0; begin < corners.size(); begin += kMost) {
    const std::size_t end = std::min(begin + kMost, corners.size());
    Lanes left = {};
    Lanes right = {};
    for (std::size_t i = begin; i < end; ++i) {
      left += load(row + corners[i]);
      right += load(row + corners[i] + kLanes);
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      sums[lane] = static_cast<std::uint16_t>(sums[lane] + left[lane]);
      sums[kLanes + lane] = static_cast<std::uint16_t>(sums[kLanes + lane] + right[lane]);
    }
  }
  return sums;
}

/// For each cell of the source, turned by `yaw`, the number of the target's cell that the least
/// shifts along both axes put it on.
std::vector<int> corners_of(const std::vector<Eigen::Vector2f>& source, double yaw) {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  std::vector<int> corners;
  corners.reserve(source.size());
  for (const auto& cell : source) {
    const Eigen::Vector2f turned = R * cell;
    const int x = cell_index(turned.x()) - kReach + kGrid / 2;
    const int y = cell_index(turned.y()) - kReach + kGrid / 2;
    corners.push_back(y * kGrid + x);
  }
  return corners;
}

struct Peak {
  int sum = -1;
  int x = 0;
  int y = 0;
};

}  // namespace

BirdsEye::BirdsEye(const std::vector<Eigen::Vector3f>& points,
                   const std::vector<bool>& above_ground) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float range = points[i].head<2>().norm();
    if (!above_ground[i] || range >= static_cast<float>(kHalf)) continue;
    occupied_.set((cell_index(points[i].y()) + kHalf) * kWidth + cell_index(points[i].x()) + kHalf);
  }
}

std::vector<Eigen::Vector2f> BirdsEye::cells() const {
  std::vector<Eigen::Vector2f> result;
  for (int i = 0; i < kWidth * kWidth; ++i) {
    if (!occupied_[i]) continue;
    result.emplace_back(static_cast<float>(i % kWidth - kHalf) + 0.5F,
                        static_cast<float>(i / kWidth - kHalf) + 0.5F);
  }
  return result;
}

ViewCorrelator::ViewCorrelator(const BirdsEye& target) : weights_(kGrid * kGrid + kLanes, 0) {
  const auto cells = target.cells();
  for (const auto& cell : cells) {
    const int x = cell_index(cell.x()) + kGrid / 2;
    const int y = cell_index(cell.y()) + kGrid / 2;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        std::uint8_t& weight = weights_[(y + dy) * kGrid + x + dx];
        weight = std::max<std::uint8_t>(weight, dx == 0 && dy == 0 ? kFull : kFull / 2);
      }
    }
  }
  norm_ = std::sqrt(static_cast<double>(cells.size()));
}

ViewMatch ViewCorrelator::match(const std::vector<Eigen::Vector2f>& source, double yaw) const {
  if (source.empty() || norm_ == 0.0) return {};
  const std::vector<int> corners = corners_of(source, yaw);
  Peak peak;
  for (int y = 0; y < kShifts; ++y) {
    const RowSums sums = row_sums(corners, &weights_[y * kGrid]);
    for (int x = 0; x < kShifts; ++x) {
      if (sums[x] > peak.sum) peak = {sums[x], x, y};
    }
  }
  ViewMatch match;
  match.translation = {peak.x - kReach, peak.y - kReach};
  match.score = peak.sum / (kFull * norm_ * std::sqrt(static_cast<double>(source.size())));
  return match;
}

}  // namespace lidar_mapping::loop_closing
