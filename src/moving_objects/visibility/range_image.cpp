// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/range_image.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace lidar_mapping::moving_objects {

namespace {

// Values of a row, by its layout: nearest and farthest range per pixel.
constexpr std::size_t kRow = 2 * kRangeImageColumns;
constexpr std::uint16_t kNothing = 65'535;  // chosen: the largest of 16 bits, above kMaxUnit
// Pixels of a row, by its layout: one more at each end.
constexpr std::size_t kExtendedRow = kRangeImageColumns + 2;
// Windows that are prefetched. Chosen: about as long as a line of memory takes to come.
constexpr std::size_t kPrefetchDistance = 8;

/// Position of the upper left pixel of the 3x3 window around a pixel, in the extended rows.
std::size_t corner_of(int pixel) {
  const auto number = static_cast<std::size_t>(pixel);
  return number + number / kRangeImageColumns * (kExtendedRow - kRangeImageColumns);
}

/// Points as directions from a sensor, an array for each quantity.
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

/// Ranges of the pixels while an image is built: the nearest, and the difference of the farthest
/// from kNothing, so that the minimum is needed of both.
struct MinimumRanges {
  explicit MinimumRanges(int rows) : values(static_cast<std::size_t>(rows) * kRow, kNothing) {}

  void add(std::size_t pixel, int range) {
    const auto value = static_cast<std::uint16_t>(range);
    values[2 * pixel] = std::min(values[2 * pixel], value);
    const auto complement = static_cast<std::uint16_t>(kNothing - value);
    values[2 * pixel + 1] = std::min(values[2 * pixel + 1], complement);
  }
  bool empty(std::size_t pixel) const { return values[2 * pixel] == kNothing; }
  RangeInterval range_interval(std::size_t pixel) const {
    return static_cast<RangeInterval>(kNothing - values[2 * pixel + 1]) << 16U | values[2 * pixel];
  }

  std::vector<std::uint16_t> values;
};

/// Ranges of the 3x3 window around each pixel.
MinimumRanges windows_of(const MinimumRanges& own, int rows) {
  MinimumRanges windows(rows);
  // minima of three rows, with a pixel more at either end
  std::vector<std::uint16_t> columns(kRow + 4);
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
      const std::uint16_t* remaining = columns.data() + i;
      window[i] = std::min(std::min(remaining[0], remaining[2]), remaining[4]);
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
  MinimumRanges own(rows_);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    own.add(pixel_at(directions.columns[i], rows[i] - first_row_), directions.ranges[i]);
  }
  const MinimumRanges windows = windows_of(own, rows_);
  const std::size_t count = own.values.size() / 2;
  windows_.resize(count + 1, kUnobserved);
  for (std::size_t i = 0; i < count; ++i) {
    if (!own.empty(i)) windows_[i] = windows.range_interval(i);
  }
  const auto height = static_cast<std::size_t>(rows_);
  pixels_.resize((height + 2) * kExtendedRow + 1, kUnobserved);  // four pixels are read at a time
  for (std::size_t row = 0; row < height; ++row) {
    RangeInterval* extended_row = pixels_.data() + (row + 1) * kExtendedRow;
    for (std::size_t i = 0; i < kRangeImageColumns; ++i)
      extended_row[i + 1] = own.range_interval(row * kRangeImageColumns + i);
    extended_row[0] = extended_row[kRangeImageColumns];
    extended_row[kExtendedRow - 1] = extended_row[1];
  }
}

void RangeImage::classify(const ProjectedPixels& targets, std::size_t count,
                          const VisibilityCounts& counts, int* ambiguous) const {
  visibility_kernels().classify(windows_.data(), targets, count, counts, ambiguous);
  std::size_t ambiguous_count = 0;  // without branches, which would be mispredicted
  for (std::size_t i = 0; i < count; ++i) {
    const int is_unclear = ambiguous[i];
    ambiguous[ambiguous_count] = static_cast<int>(i);
    ambiguous_count += static_cast<std::size_t>(is_unclear);
  }
  for (std::size_t n = 0; n < ambiguous_count; ++n) {
    if (n + kPrefetchDistance < ambiguous_count)
      prefetch_window(targets.pixels[ambiguous[n + kPrefetchDistance]]);
    const int i = ambiguous[n];
    counts.hits[i] += is_hit_around(targets.pixels[i], targets.nearest[i], targets.farthest[i]);
  }
}

void RangeImage::prefetch_window(int pixel) const {
  const RangeInterval* corner = pixels_.data() + corner_of(pixel);
  for (std::size_t row = 0; row < 3; ++row) __builtin_prefetch(corner + row * kExtendedRow);
}

/// Returns 1 if one of the 3x3 pixels was hit in this interval of ranges, else 0. A location
/// between the two ranges of a pixel was not hit: at an edge the pixel holds an object and the wall
/// behind it.
int RangeImage::is_hit_around(int pixel, int nearest, int farthest) const {
  using Ranges = std::uint16_t __attribute__((vector_size(16)));  // the ranges of four pixels
  constexpr auto kAll = std::uint16_t{0xFFFF};  // all bits of a range, by definition
  constexpr Ranges kThreePixels = {kAll, kAll, kAll, kAll, kAll, kAll, 0, 0};
  const auto low = static_cast<std::uint16_t>(nearest);
  const auto width = static_cast<std::uint16_t>(farthest - nearest);
  const std::size_t corner = corner_of(pixel);
  Ranges is_hit{};
  for (std::size_t row = 0; row < 3; ++row) {
    Ranges ranges;
    std::memcpy(&ranges, pixels_.data() + corner + row * kExtendedRow, sizeof ranges);
    is_hit |= (ranges - low <= width);
  }
  is_hit &= kThreePixels;
  std::array<std::uint64_t, 2> halves{};
  std::memcpy(halves.data(), &is_hit, sizeof is_hit);
  return (halves[0] | halves[1]) != 0 ? 1 : 0;
}

}  // namespace lidar_mapping::moving_objects
