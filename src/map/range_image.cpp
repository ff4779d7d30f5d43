#include "range_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidar_mapping::map {

namespace {

constexpr float kPi = static_cast<float>(M_PI);
constexpr float kColumnsPerRadian = kRangeImageColumns / (2.0F * kPi);
constexpr float kRowsPerRadian = 2.0F * 180.0F / kPi;
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kMargin = 0.2F;           // m
constexpr float kMarginPerRange = 0.02F;  // m per m

int wrapped(int column) {
  if (column < 0) return column + kRangeImageColumns;
  return column < kRangeImageColumns ? column : column - kRangeImageColumns;
}

/// atan2 to 2e-5 rad, by a polynomial: a pixel is three hundred times as wide. Without branches, so
/// that loops over it become vectors.
inline float angle_of(float y, float x) {
  const float along = std::abs(x);
  const float across = std::abs(y);
  const float longer = std::max(std::max(along, across), std::numeric_limits<float>::min());
  const float a = std::min(along, across) / longer;
  const float s = a * a;
  const float low =
      a * (0.99997726F +
           s * (-0.33262347F +
                s * (0.19354346F + s * (-0.11643287F + s * (0.05265332F - s * 0.01172120F)))));
  const float high = 0.5F * kPi - low;
  const float half = across > along ? high : low;
  const float other = kPi - half;
  const float angle = x < 0.0F ? other : half;
  return y < 0.0F ? -angle : angle;
}

}  // namespace

void SensorPoints::resize(std::size_t size) {
  for (std::vector<float>* values : {&x, &y, &z}) values->resize(size);
}

void Directions::project(const SensorPoints& points) {
  const std::size_t count = points.size();
  columns.resize(count);
  rows.resize(count);
  ranges.resize(count);
  const float* x = points.x.data();
  const float* y = points.y.data();
  const float* z = points.z.data();
  int* column = columns.data();
  int* row = rows.data();
  float* range = ranges.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    const float squared = x[i] * x[i] + y[i] * y[i];
    const float azimuth = angle_of(y[i], x[i]) + kPi;
    const float elevation =
        angle_of(z[i], std::sqrt(squared)) + kPi;  // above zero: truncated below
    const int turned = static_cast<int>(azimuth * kColumnsPerRadian);
    column[i] = turned < kRangeImageColumns ? turned : turned - kRangeImageColumns;
    row[i] = static_cast<int>(elevation * kRowsPerRadian);
    range[i] = std::sqrt(squared + z[i] * z[i]);
  }
}

RangeImage::RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor) {
  SensorPoints seen;
  seen.resize(cloud.size());
  std::size_t count = 0;
  for (const Point& point : cloud.points) {
    if (!point.position().allFinite()) continue;
    const Eigen::Vector3f p_sensor = point.position() - sensor;
    seen.x[count] = p_sensor.x();
    seen.y[count] = p_sensor.y();
    seen.z[count++] = p_sensor.z();
  }
  if (count == 0) return;
  seen.resize(count);
  Directions directions;
  directions.project(seen);
  const auto [low, high] = std::minmax_element(directions.rows.begin(), directions.rows.end());
  first_row_ = *low;
  rows_ = *high - *low + 1;
  constexpr Seen kEmpty = {kNothing, 0.0F};
  pixels_.assign(static_cast<std::size_t>(rows_) * kRangeImageColumns, {kEmpty, kEmpty});
  for (std::size_t i = 0; i < count; ++i) {
    Seen& own = pixels_[at(directions.columns[i], directions.rows[i] - first_row_)].own;
    own.nearest = std::min(own.nearest, directions.ranges[i]);
    own.farthest = std::max(own.farthest, directions.ranges[i]);
  }
  close_window();
}

void RangeImage::look(const Directions& directions, std::vector<Sight>& sights) const {
  constexpr std::size_t kAhead = 12;  // pixels that are on their way from memory
  const auto row = [&](std::size_t i) { return directions.rows[i] - first_row_; };
  const std::size_t count = directions.rows.size();
  sights.assign(count, Sight::kUnknown);
  if (rows_ == 0) return;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = std::min(i + kAhead, count - 1);
    const int next_row = std::clamp(row(next), 0, rows_ - 1);
    __builtin_prefetch(pixels_.data() + at(directions.columns[next], next_row));
    sights[i] = sight_of(directions.columns[i], row(i), directions.ranges[i]);
  }
}

Sight RangeImage::sight_of(int column, int row, float range) const {
  if (row < 0 || row >= rows_) return Sight::kUnknown;
  const Pixel& pixel = pixels_[at(column, row)];
  if (pixel.own.nearest == kNothing) return Sight::kUnknown;
  const float margin = kMargin + kMarginPerRange * range;
  const float nearest = range - margin;
  const float farthest = range + margin;
  if (pixel.around.nearest > farthest) return Sight::kSeenThrough;
  if (pixel.around.farthest < nearest) return Sight::kUnknown;
  if (is_within(pixel.own, nearest, farthest) || is_hit_around(column, row, nearest, farthest))
    return Sight::kHit;
  return Sight::kUnknown;
}

bool RangeImage::is_hit_around(int column, int row, float nearest, float farthest) const {
  for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
    for (int c = -1; c <= 1; ++c) {
      if (is_within(pixels_[at(wrapped(column + c), r)].own, nearest, farthest)) return true;
    }
  }
  return false;
}

void RangeImage::close_window() {
  const auto join = [](Seen& to, const Seen& from) {
    to.nearest = std::min(to.nearest, from.nearest);
    to.farthest = std::max(to.farthest, from.farthest);
  };
  std::vector<Seen> columns(kRangeImageColumns);  // of three rows
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < kRangeImageColumns; ++column) {
      Seen& joined = columns[static_cast<std::size_t>(column)] = {kNothing, 0.0F};
      for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
        join(joined, pixels_[at(column, r)].own);
      }
    }
    for (int column = 0; column < kRangeImageColumns; ++column) {
      for (int c = -1; c <= 1; ++c) {
        join(pixels_[at(column, row)].around,
             columns[static_cast<std::size_t>(wrapped(column + c))]);
      }
    }
  }
}

}  // namespace lidar_mapping::map
