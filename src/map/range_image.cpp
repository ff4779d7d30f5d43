#include "range_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr int kColumns = 900;
constexpr float kPi = static_cast<float>(M_PI);
constexpr float kColumnsPerRadian = 900.0F / (2.0F * kPi);
constexpr float kRowsPerRadian = 2.0F * 180.0F / kPi;
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kMargin = 0.2F;           // m
constexpr float kMarginPerRange = 0.01F;  // m per m

struct Direction {
  int column;
  int row;  ///< may lie outside of the image
  float range;
};

int wrapped(int column) {
  if (column < 0) return column + kColumns;
  return column < kColumns ? column : column - kColumns;
}

/// atan2 to 2e-5 rad, by a polynomial: half of the time went into the exact one, and a pixel is
/// three hundred times as wide.
float angle_of(float y, float x) {
  const float longer = std::max(std::abs(x), std::abs(y));
  const float a = longer > 0.0F ? std::min(std::abs(x), std::abs(y)) / longer : 0.0F;
  const float s = a * a;
  float angle =
      a * (0.99997726F +
           s * (-0.33262347F +
                s * (0.19354346F + s * (-0.11643287F + s * (0.05265332F - s * 0.01172120F)))));
  if (std::abs(y) > std::abs(x)) angle = 0.5F * kPi - angle;
  if (x < 0.0F) angle = kPi - angle;
  return y < 0.0F ? -angle : angle;
}

Direction direction_of(const Eigen::Vector3f& p_sensor) {
  const float horizontal = std::sqrt(p_sensor.x() * p_sensor.x() + p_sensor.y() * p_sensor.y());
  const float azimuth = angle_of(p_sensor.y(), p_sensor.x()) + kPi;
  const float elevation = angle_of(p_sensor.z(), horizontal) + kPi;  // above zero: truncated below
  return {wrapped(static_cast<int>(azimuth * kColumnsPerRadian)),
          static_cast<int>(elevation * kRowsPerRadian), p_sensor.norm()};
}

}  // namespace

RangeImage::RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor) {
  std::vector<Direction> directions;
  directions.reserve(cloud.size());
  int low = std::numeric_limits<int>::max();
  int high = std::numeric_limits<int>::min();
  for (const Point& point : cloud.points) {
    if (!point.position().allFinite()) continue;
    directions.push_back(direction_of(point.position() - sensor));
    low = std::min(low, directions.back().row);
    high = std::max(high, directions.back().row);
  }
  if (directions.empty()) return;
  first_row_ = low;
  rows_ = high - low + 1;
  constexpr Seen kEmpty = {kNothing, 0.0F};
  pixels_.assign(static_cast<std::size_t>(rows_) * kColumns, {kEmpty, kEmpty});
  for (const Direction& direction : directions) {
    Seen& own = pixels_[at(direction.column, direction.row - first_row_)].own;
    own.nearest = std::min(own.nearest, direction.range);
    own.farthest = std::max(own.farthest, direction.range);
  }
  close_window();
}

Sight RangeImage::sight_of(const Eigen::Vector3f& p_sensor) const {
  const Direction direction = direction_of(p_sensor);
  const int row = direction.row - first_row_;
  if (row < 0 || row >= rows_) return Sight::kUnknown;
  const Pixel& pixel = pixels_[at(direction.column, row)];
  if (pixel.own.nearest == kNothing) return Sight::kUnknown;
  const float margin = kMargin + kMarginPerRange * direction.range;
  const float nearest = direction.range - margin;
  const float farthest = direction.range + margin;
  if (pixel.around.nearest > farthest) return Sight::kSeenThrough;
  if (pixel.around.farthest < nearest) return Sight::kUnknown;
  if (is_within(pixel.own, nearest, farthest) ||
      is_hit_around(direction.column, row, nearest, farthest))
    return Sight::kHit;
  return Sight::kUnknown;
}

/// What lies between the two was not hit: a pixel on an edge sees a thing and a wall behind it.
bool RangeImage::is_within(const Seen& seen, float nearest, float farthest) {
  return (seen.nearest >= nearest && seen.nearest <= farthest) ||
         (seen.farthest >= nearest && seen.farthest <= farthest);
}

bool RangeImage::is_hit_around(int column, int row, float nearest, float farthest) const {
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
    for (int c = -1; c <= 1; ++c) {
      if (is_within(pixels_[at(wrapped(column + c), r)].own, nearest, farthest)) return true;
    }
  }
  return false;
}

std::size_t RangeImage::at(int column, int row) const {
  return static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
}

void RangeImage::close_window() {
  const auto join = [](Seen& to, const Seen& from) {
    to.nearest = std::min(to.nearest, from.nearest);
    to.farthest = std::max(to.farthest, from.farthest);
  };
  std::vector<Seen> columns(kColumns);  // of three rows
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      Seen& joined = columns[static_cast<std::size_t>(column)] = {kNothing, 0.0F};
      for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
        join(joined, pixels_[at(column, r)].own);
      }
    }
    for (int column = 0; column < kColumns; ++column) {
      for (int c = -1; c <= 1; ++c) {
        join(pixels_[at(column, row)].around,
             columns[static_cast<std::size_t>(wrapped(column + c))]);
      }
    }
  }
}

}  // namespace lidar_mapping::map
