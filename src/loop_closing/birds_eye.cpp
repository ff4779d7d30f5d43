#include "lidar_mapping/loop_closing/birds_eye.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidar_mapping::loop_closing {

namespace {

constexpr int kHalf = BirdsEye::kWidth / 2;
constexpr int kReach = 15;  // cells
constexpr int kShifts = 2 * kReach + 1;
constexpr int kRim = kReach + 1;  // cells around the target, so that no shift leaves the grid
constexpr int kGrid = BirdsEye::kWidth + 2 * kRim;
constexpr std::uint8_t kFull = 2;  // an occupied cell; its neighbours count half

int cell_index(float coordinate) { return static_cast<int>(std::floor(coordinate)); }

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

ViewCorrelator::ViewCorrelator(const BirdsEye& target) : weights_(kGrid * kGrid, 0) {
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
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  std::array<std::uint16_t, kShifts * kShifts> sums{};
  for (const auto& cell : source) {
    const Eigen::Vector2f turned = R * cell;
    const int x = cell_index(turned.x()) - kReach + kGrid / 2;
    const int y = cell_index(turned.y()) - kReach + kGrid / 2;
    for (int dy = 0; dy < kShifts; ++dy) {
      const std::uint8_t* weight = &weights_[(y + dy) * kGrid + x];
      std::uint16_t* sum = &sums[dy * kShifts];
      for (int dx = 0; dx < kShifts; ++dx) {
        sum[dx] = static_cast<std::uint16_t>(sum[dx] + weight[dx]);
      }
    }
  }
  const auto peak = std::max_element(sums.begin(), sums.end());
  const int offset = static_cast<int>(peak - sums.begin());
  ViewMatch match;
  match.translation = {offset % kShifts - kReach, offset / kShifts - kReach};
  match.score = *peak / (kFull * norm_ * std::sqrt(static_cast<double>(source.size())));
  return match;
}

}  // namespace lidar_mapping::loop_closing
