// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/top_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <png.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::map {

namespace {

using Color = std::array<double, 3>;

constexpr float kNone = std::numeric_limits<float>::infinity();
// m above the ground; higher points have the last colour. Chosen: houses of three storeys.
constexpr double kMaxHeight = 10.0;
// m, edge of the cells in which the ground has one height. Chosen: below every car there is ground,
// and the steepest streets (12 %) rise by less than 1 m.
constexpr double kGroundCell = 8.0;
// Fraction of the points of a cell that may lie below its ground. Chosen: wet roads and glass
// mirror no more.
constexpr double kGroundQuantile = 0.03;
// Points from which the ground is computed. Chosen: bounds the memory (16 MB).
constexpr std::size_t kMaxHeightSamples = 4'000'000;
constexpr int kLevels = 255;          // of height, so that one fits into a byte
constexpr int kMaxCountedPoints = 9;  // in a pixel; chosen: more do not make it brighter
constexpr Color kBackground = {12.0, 14.0, 20.0};
constexpr std::array<Color, 5> kScale = {{{96.0, 116.0, 150.0},
                                          {60.0, 175.0, 185.0},
                                          {130.0, 210.0, 100.0},
                                          {245.0, 210.0, 70.0},
                                          {230.0, 80.0, 60.0}}};

/// A grid over the x-y plane with one value per cell.
template <typename Value>
struct Grid {
  Grid(double x_low, double y_high, double x_size, double y_size, double cell_size, Value value)
      : x_min(x_low),
        y_max(y_high),
        cell(cell_size),
        width(static_cast<int>(x_size / cell_size) + 1),
        height(static_cast<int>(y_size / cell_size) + 1),
        values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value) {}

  std::size_t position(const Point& point) const {
    const auto column = static_cast<int>((static_cast<double>(point.x) - x_min) / cell);
    const auto row = static_cast<int>((y_max - static_cast<double>(point.y)) / cell);
    return static_cast<std::size_t>(std::clamp(row, 0, height - 1)) *
               static_cast<std::size_t>(width) +
           static_cast<std::size_t>(std::clamp(column, 0, width - 1));
  }
  Value& at(const Point& point) { return values[position(point)]; }

  double x_min;
  double y_max;
  double cell;
  int width;
  int height;
  std::vector<Value> values;
};

struct Extent {
  std::size_t points = 0;
  Eigen::AlignedBox2f bounds;
};

/// Height of the ground in every cell.
Grid<float> ground_of(const CloudParts& map, const Extent& extent, Grid<float> ground) {
  std::vector<std::vector<float>> heights(ground.values.size());
  const std::size_t step = 1 + extent.points / kMaxHeightSamples;
  std::size_t number = 0;
  map.for_each([&](const PointCloud& part) {
    for (const Point& point : part.points) {
      if (number++ % step == 0) heights[ground.position(point)].push_back(point.z);
    }
  });
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (heights[i].empty()) continue;
    ground.values[i] = quantile_of_range(heights[i].begin(), heights[i].end(), kGroundQuantile);
  }
  return ground;
}

Extent extent_of(const CloudParts& map) {
  Extent extent;
  map.for_each([&](const PointCloud& part) {
    extent.points += part.size();
    for (const Point& point : part.points) extent.bounds.extend(point.position().head<2>());
  });
  if (extent.points == 0) throw InputError("the map has no points; there is nothing to draw");
  return extent;
}

/// Colour of a height, given as a fraction of the highest one.
Color color_of(double height, double density) {
  const double scaled = height * static_cast<double>(kScale.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(scaled), kScale.size() - 2);
  const double fraction = scaled - static_cast<double>(below);
  Color color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double full = kScale[below][i] + fraction * (kScale[below + 1][i] - kScale[below][i]);
    color[i] = kBackground[i] + density * (full - kBackground[i]);
  }
  return color;
}

/// Content of a pixel; small, because there are many.
struct Pixel {
  std::uint8_t height = 0;  ///< Level of the highest point; kLevels is kMaxHeight.
  std::uint8_t points = 0;  ///< Number of points, up to kMaxCountedPoints.

  void add(float above_ground) {
    const double fraction = std::clamp(static_cast<double>(above_ground) / kMaxHeight, 0.0, 1.0);
    height = std::max(height, static_cast<std::uint8_t>(std::lround(fraction * kLevels)));
    points = static_cast<std::uint8_t>(std::min(points + 1, kMaxCountedPoints));
  }
};

using Rgb = std::array<std::uint8_t, 3>;

/// Colours of all possible pixels, by number of points and level of height.
std::vector<Rgb> palette() {
  std::vector<Rgb> colors;
  for (int points = 0; points <= kMaxCountedPoints; ++points) {
    const double density = points == 0 ? 0.0 : std::min(1.0, 0.75 + 0.08 * std::log2(points));
    for (int height = 0; height <= kLevels; ++height) {
      const Color color = color_of(static_cast<double>(height) / kLevels, density);
      Rgb rgb;
      for (std::size_t i = 0; i < 3; ++i) rgb[i] = static_cast<std::uint8_t>(std::lround(color[i]));
      colors.push_back(rgb);
    }
  }
  return colors;
}

std::string world_file(const TopView& view) {
  return formatted("%.9f\n0.0\n0.0\n%.9f\n%.6f\n%.6f\n", view.pixel_m, -view.pixel_m,
                   view.x_min + 0.5 * view.pixel_m, view.y_max - 0.5 * view.pixel_m);
}

}  // namespace

TopView top_view(const CloudParts& map, double pixel_m, int max_pixels) {
  const Extent extent = extent_of(map);
  const double x_min = static_cast<double>(extent.bounds.min().x());
  const double y_max = static_cast<double>(extent.bounds.max().y());
  const double x_size = static_cast<double>(extent.bounds.max().x()) - x_min;
  const double y_size = y_max - static_cast<double>(extent.bounds.min().y());
  const double pixel = std::max(pixel_m, std::max(x_size, y_size) / (max_pixels - 1));
  Grid<float> ground =
      ground_of(map, extent, Grid<float>(x_min, y_max, x_size, y_size, kGroundCell, kNone));
  Grid<Pixel> pixels(x_min, y_max, x_size, y_size, pixel, {});
  map.for_each([&](const PointCloud& part) {
    for (const Point& point : part.points) pixels.at(point).add(point.z - ground.at(point));
  });
  TopView view{pixels.width, pixels.height, pixel, x_min, y_max, {}};
  view.rgb.reserve(3 * pixels.values.size());
  const std::vector<Rgb> colors = palette();
  for (const Pixel& pixel_content : pixels.values) {
    const Rgb& rgb = colors[static_cast<std::size_t>(pixel_content.points * (kLevels + 1) +
                                                     pixel_content.height)];
    view.rgb.insert(view.rgb.end(), rgb.begin(), rgb.end());
  }
  return view;
}

void write_png(const std::filesystem::path& path, const TopView& view) {
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(view.width);
    image.height = static_cast<png_uint_32>(view.height);
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;
    if (png_image_write_to_file(&image, temporary.c_str(), 0, view.rgb.data(), 0, nullptr) == 0) {
      throw FileError("cannot write " + path.string() + ": " + image.message);
    }
  });
  std::filesystem::path world = path;
  write_text_atomically(world.replace_extension(".pgw"), world_file(view));
}

}  // namespace lidar_mapping::map
