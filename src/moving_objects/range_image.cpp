// SPDX-License-Identifier: BSD-3-Clause
#include "range_image.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kRow = 2 * kRangeImageColumns;  // values of a row, two a pixel
constexpr std::uint16_t kNothing = 65'535;
constexpr std::size_t kWide = kRangeImageColumns + 2;  // pixels of a row with one more at each end
constexpr std::size_t kAhead = 8;  // windows that are fetched while others are looked at

/// Where the 3x3 window around a pixel begins in the wide rows.
std::size_t corner_of(int pixel) {
  const auto number = static_cast<std::size_t>(pixel);
  return number + number / kRangeImageColumns * (kWide - kRangeImageColumns);
}

/// Points in directions from a sensor, one array for each quantity.
struct Directions {
  Directions(const PointCloud& cloud, const Eigen::Vector3f& sensor) {
    std::vector<float> x(cloud.size()), y(cloud.size()), z(cloud.size());
    std::size_t count = 0;
    for (const Point& point : cloud.points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3f p_sensor = point.position() - sensor;
      x[count] = p_sensor.x();
      y[count] = p_sensor.y();
      z[count++] = p_sensor.z();
    }
    for (std::vector<int>* values : {&columns, &rows, &ranges}) values->resize(count);
    visibility_kernels().project({x.data(), y.data(), z.data()}, count, columns.data(), rows.data(),
                                 ranges.data());
  }

  std::vector<int> columns, rows, ranges;
};

/// Ranges by pixel while an image is made: the nearest, and the farthest as what it lacks to
/// kNothing, so that the smallest value counts of both.
struct Lows {
  explicit Lows(int rows) : values(static_cast<std::size_t>(rows) * kRow, kNothing) {}

  void take(std::size_t pixel, int range) {
    const auto value = static_cast<std::uint16_t>(range);
    values[2 * pixel] = std::min(values[2 * pixel], value);
    const auto lack = static_cast<std::uint16_t>(kNothing - value);
    values[2 * pixel + 1] = std::min(values[2 * pixel + 1], lack);
  }
  bool empty(std::size_t pixel) const { return values[2 * pixel] == kNothing; }
  Seen seen(std::size_t pixel) const {
    return static_cast<Seen>(kNothing - values[2 * pixel + 1]) << 16U | values[2 * pixel];
  }

  std::vector<std::uint16_t> values;
};

/// Of the 3x3 window around each pixel.
Lows windows_of(const Lows& own, int rows) {
  Lows windows(rows);
  std::vector<std::uint16_t> columns(kRow + 4);  // of three rows, with a pixel at either end
  for (int row = 0; row < rows; ++row) {
    const auto values = [&](int r) {
      return own.values.data() + static_cast<std::size_t>(std::clamp(r, 0, rows - 1)) * kRow;
    };
    const std::uint16_t* above = values(row - 1);
    const std::uint16_t* here = values(row);
    const std::uint16_t* below = values(row + 1);
    std::uint16_t* column = columns.data() + 2;
    for (std::size_t i = 0; i < kRow; ++i)
      column[i] = std::min(std::min(above[i], below[i]), here[i]);
    std::copy_n(column + kRow - 2, 2, columns.data());
    std::copy_n(column, 2, column + kRow);
    std::uint16_t* window = windows.values.data() + static_cast<std::size_t>(row) * kRow;
    for (std::size_t i = 0; i < kRow; ++i) {
      const std::uint16_t* left = columns.data() + i;
      window[i] = std::min(std::min(left[0], left[2]), left[4]);
    }
  }
  return windows;
}

}  // namespace

RangeImage::RangeImage(const PointCloud& cloud, const Eigen::Vector3f& sensor) {
  const Directions directions(cloud, sensor);
  const std::vector<int>& rows = directions.rows;
  if (!rows.empty()) {
    const auto [low, high] = std::minmax_element(rows.begin(), rows.end());
    first_row_ = *low;
    rows_ = *high - *low + 1;
  }
  Lows own(rows_);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    own.take(pixel_at(directions.columns[i], rows[i] - first_row_), directions.ranges[i]);
  }
  const Lows windows = windows_of(own, rows_);
  const std::size_t count = own.values.size() / 2;
  windows_.resize(count + 1, kSeenHidden);
  for (std::size_t i = 0; i < count; ++i) {
    if (!own.empty(i)) windows_[i] = windows.seen(i);
  }
  const auto height = static_cast<std::size_t>(rows_);
  pixels_.resize((height + 2) * kWide + 1, kSeenHidden);  // four are read at a time
  for (std::size_t row = 0; row < height; ++row) {
    Seen* wide = pixels_.data() + (row + 1) * kWide;
    for (std::size_t i = 0; i < kRangeImageColumns; ++i)
      wide[i + 1] = own.seen(row * kRangeImageColumns + i);
    wide[0] = wide[kRangeImageColumns];
    wide[kWide - 1] = wide[1];
  }
}

void RangeImage::look(const ProjectedPixels& targets, std::size_t count, const Counts& counts,
                      int* unclear) const {
  visibility_kernels().look(windows_.data(), targets, count, counts, unclear);
  std::size_t open = 0;  // without branches, which nobody foresees
  for (std::size_t i = 0; i < count; ++i) {
    const int is_unclear = unclear[i];
    unclear[open] = static_cast<int>(i);
    open += static_cast<std::size_t>(is_unclear);
  }
  for (std::size_t n = 0; n < open; ++n) {
    if (n + kAhead < open) fetch_around(targets.pixels[unclear[n + kAhead]]);
    const int i = unclear[n];
    counts.hits[i] += is_hit_around(targets.pixels[i], targets.nearest[i], targets.farthest[i]);
  }
}

void RangeImage::fetch_around(int pixel) const {
  const Seen* corner = pixels_.data() + corner_of(pixel);
  for (std::size_t row = 0; row < 3; ++row) __builtin_prefetch(corner + row * kWide);
}

/// One or none. What lies between the two of a pixel was not hit: on an edge it sees a thing and a
/// wall behind it.
int RangeImage::is_hit_around(int pixel, int nearest, int farthest) const {
  using Ranges = std::uint16_t __attribute__((vector_size(16)));  // of four pixels
  constexpr auto kAll = std::uint16_t{0xFFFF};
  constexpr Ranges kThreePixels = {kAll, kAll, kAll, kAll, kAll, kAll, 0, 0};
  const auto low = static_cast<std::uint16_t>(nearest);
  const auto width = static_cast<std::uint16_t>(farthest - nearest);
  const std::size_t corner = corner_of(pixel);
  Ranges is_hit{};
  for (std::size_t row = 0; row < 3; ++row) {
    Ranges ranges;
    std::memcpy(&ranges, pixels_.data() + corner + row * kWide, sizeof ranges);
    is_hit |= (ranges - low <= width);
  }
  is_hit &= kThreePixels;
  std::array<std::uint64_t, 2> halves{};
  std::memcpy(halves.data(), &is_hit, sizeof is_hit);
  return (halves[0] | halves[1]) != 0 ? 1 : 0;
}

}  // namespace lidar_mapping::moving_objects
