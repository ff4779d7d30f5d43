#include "range_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr int kColumns = 900;
constexpr float kColumnsPerRadian = 900.0F / (2.0F * static_cast<float>(M_PI));
constexpr float kRowsPerRadian = 2.0F * 180.0F / static_cast<float>(M_PI);
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kMargin = 0.2F;           // m
constexpr float kMarginPerRange = 0.01F;  // m per m

int wrapped(int column) { return (column + kColumns) % kColumns; }

}  // namespace

RangeImage::RangeImage(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Direction> directions;
  directions.reserve(points.size());
  int low = std::numeric_limits<int>::max();
  int high = std::numeric_limits<int>::min();
  for (const Eigen::Vector3f& point : points) {
    directions.push_back(direction_of(point));
    low = std::min(low, directions.back().row);
    high = std::max(high, directions.back().row);
  }
  if (points.empty()) return;
  first_row_ = low;
  rows_ = high - low + 1;
  pixels_.assign(static_cast<std::size_t>(rows_) * kColumns, {kNothing, 0.0F});
  for (const Direction& direction : directions) {
    Pixel& pixel = pixels_[at(direction.column, direction.row)];
    pixel.nearest = std::min(pixel.nearest, direction.range);
    pixel.farthest = std::max(pixel.farthest, direction.range);
  }
  close_window();
}

Sight RangeImage::sight_of(const Eigen::Vector3f& p_sensor) const {
  const Direction direction = direction_of(p_sensor);
  const int row = direction.row - first_row_;
  if (row < 0 || row >= rows_) return Sight::kUnknown;
  const std::size_t centre = at(direction.column, direction.row);
  if (pixels_[centre].nearest == kNothing) return Sight::kUnknown;
  const float margin = kMargin + kMarginPerRange * direction.range;
  if (nearest_around_[centre] > direction.range + margin) return Sight::kSeenThrough;
  const auto is_hit = [&](const Pixel& pixel) {
    return pixel.nearest <= direction.range + margin && pixel.farthest >= direction.range - margin;
  };
  if (is_hit(pixels_[centre])) return Sight::kHit;  // mostly, and cheaper than its neighbours
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
    for (int c = -1; c <= 1; ++c) {
      if (is_hit(pixels_[at(wrapped(direction.column + c), r + first_row_)])) return Sight::kHit;
    }
  }
  return Sight::kUnknown;
}

RangeImage::Direction RangeImage::direction_of(const Eigen::Vector3f& p_sensor) {
  const float horizontal = std::hypot(p_sensor.x(), p_sensor.y());
  const float azimuth = std::atan2(p_sensor.y(), p_sensor.x()) + static_cast<float>(M_PI);
  const float elevation = std::atan2(p_sensor.z(), horizontal);
  return {wrapped(static_cast<int>(azimuth * kColumnsPerRadian)),
          static_cast<int>(std::floor(elevation * kRowsPerRadian)), p_sensor.norm()};
}

std::size_t RangeImage::at(int column, int row) const {
  return static_cast<std::size_t>(row - first_row_) * kColumns + static_cast<std::size_t>(column);
}

void RangeImage::close_window() {
  nearest_around_.assign(pixels_.size(), kNothing);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      float& nearest = nearest_around_[at(column, row + first_row_)];
      for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
        for (int c = -1; c <= 1; ++c) {
          nearest = std::min(nearest, pixels_[at(wrapped(column + c), r + first_row_)].nearest);
        }
      }
    }
  }
}

}  // namespace lidar_mapping::map
