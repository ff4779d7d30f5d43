// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/top_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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
// Points from which the extent and the ground are computed. Chosen: bounds the memory (64 MB).
constexpr std::size_t kMaxSamples = 4'000'000;
// Fraction of the points that may be stray ones on each side of the picture. Chosen: of a recorded
// hall 0.01 % lie outside of its walls, through doors and by reflections.
constexpr double kStrayFraction = 2e-4;
// Border around all other points, as a fraction of their extent, that the picture has for the sake
// of points farther outside. Chosen: what is drawn in vain is at most a third of the picture.
constexpr double kBorder = 0.1;
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

  /// Nothing for a point outside of the grid.
  std::optional<std::size_t> position(const Point& point) const {
    const double column = std::floor((static_cast<double>(point.x) - x_min) / cell);
    const double row = std::floor((y_max - static_cast<double>(point.y)) / cell);
    if (column < 0.0 || column >= width || row < 0.0 || row >= height) return std::nullopt;
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }

  double x_min;
  double y_max;
  double cell;
  int width;
  int height;
  std::vector<Value> values;
};

/// Visits at most kMaxSamples points of the map, which has `count` in all.
template <typename Visit>
void for_some_points(const CloudParts& map, std::size_t count, const Visit& visit) {
  const std::size_t step = 1 + count / kMaxSamples;
  std::size_t number = 0;
  map.for_each_point([&](const Point& point) {
    if (number++ % step == 0) visit(point);
  });
}

struct Range {
  double low = 0.0;
  double high = 0.0;
  double size() const { return high - low; }
};

struct ViewExtent {
  std::size_t points = 0;
  Range x, y;
};

/// Height of the ground in every cell.
Grid<float> ground_of(const CloudParts& map, const ViewExtent& extent, Grid<float> ground) {
  // By cell, because most cells of a wide map have no points.
  std::vector<std::pair<std::size_t, float>> heights;
  heights.reserve(std::min(extent.points, kMaxSamples));
  for_some_points(map, extent.points, [&](const Point& point) {
    if (const auto position = ground.position(point)) heights.emplace_back(*position, point.z);
  });
  std::sort(heights.begin(), heights.end());
  for (auto begin = heights.begin(); begin != heights.end();) {
    const std::size_t cell = begin->first;
    const auto end = std::find_if(begin, heights.end(),
                                  [&](const auto& height) { return height.first != cell; });
    ground.values[cell] = quantile_of_range(begin, end, kGroundQuantile).second;
    begin = end;
  }
  return ground;
}

/// All coordinates, but not stray ones that are far from the others.
Range range_of(std::vector<float> coordinates) {
  const auto [lowest, highest] = std::minmax_element(coordinates.begin(), coordinates.end());
  const Range all{*lowest, *highest};
  const auto at = [&](double fraction) {
    return static_cast<double>(quantile_of_range(coordinates.begin(), coordinates.end(), fraction));
  };
  const Range most{at(kStrayFraction), at(1.0 - kStrayFraction)};
  const double border = kBorder * most.size();
  return {std::max(all.low, most.low - border), std::min(all.high, most.high + border)};
}

ViewExtent extent_of(const CloudParts& map) {
  ViewExtent extent;
  map.for_each([&](const PointCloud& part) { extent.points += part.size(); });
  if (extent.points == 0) throw InputError("the map has no points; there is nothing to draw");
  std::vector<float> x, y;
  for_some_points(map, extent.points, [&](const Point& point) {
    x.push_back(point.x);
    y.push_back(point.y);
  });
  extent.x = range_of(std::move(x));
  extent.y = range_of(std::move(y));
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
  const ViewExtent extent = extent_of(map);
  const double pixel =
      std::max(pixel_m, std::max(extent.x.size(), extent.y.size()) / (max_pixels - 1));
  const auto grid = [&](double cell, auto value) {
    return Grid<decltype(value)>(extent.x.low, extent.y.high, extent.x.size(), extent.y.size(),
                                 cell, value);
  };
  const Grid<float> ground = ground_of(map, extent, grid(kGroundCell, kNone));
  Grid<Pixel> pixels = grid(pixel, Pixel{});
  map.for_each_point([&](const Point& point) {
    const auto at_pixel = pixels.position(point);
    const auto at_ground = ground.position(point);
    if (at_pixel && at_ground) {
      pixels.values[*at_pixel].add(point.z - ground.values[*at_ground]);
    }
  });
  TopView view{pixels.width, pixels.height, pixel, extent.x.low, extent.y.high, {}};
  view.rgb.reserve(3 * pixels.values.size());
  const std::vector<Rgb> colors = palette();
  for (const Pixel& pixel_content : pixels.values) {
    const Rgb& rgb = colors[pixel_content.points * (kLevels + 1) + pixel_content.height];
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
