#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_products.hpp"

#include "local_ground.hpp"

namespace lidar_mapping::map {

namespace {

// What map_server takes for occupied, free and unknown.
constexpr std::uint8_t kOccupied = 0;
constexpr std::uint8_t kFree = 254;
constexpr std::uint8_t kUnknown = 205;

/// Counts by cell, rows from above.
class Cells {
 public:
  Cells(const PointCloud& map, double cell) : cell_(cell) {
    Eigen::Vector3f low = map.points.front().position();
    Eigen::Vector3f high = low;
    for (const Point& point : map.points) {
      low = low.cwiseMin(point.position());
      high = high.cwiseMax(point.position());
    }
    x_min_ = cell * std::floor(static_cast<double>(low.x()) / cell);
    y_min_ = cell * std::floor(static_cast<double>(low.y()) / cell);
    columns_ = static_cast<int>((static_cast<double>(high.x()) - x_min_) / cell) + 1;
    rows_ = static_cast<int>((static_cast<double>(high.y()) - y_min_) / cell) + 1;
    const auto size = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    obstacles_.assign(size, 0);
    ground_.assign(size, 0);
  }

  void add(const Point& point, float height, const GridOptions& options) {
    const auto column = static_cast<int>((static_cast<double>(point.x) - x_min_) / cell_);
    const auto row = static_cast<int>((static_cast<double>(point.y) - y_min_) / cell_);
    const std::size_t at = static_cast<std::size_t>(rows_ - 1 - std::min(row, rows_ - 1)) *
                               static_cast<std::size_t>(columns_) +
                           static_cast<std::size_t>(std::min(column, columns_ - 1));
    if (static_cast<double>(height) < options.lowest) {
      ground_[at] = 1;
    } else if (static_cast<double>(height) <= options.highest) {
      ++obstacles_[at];
    }
  }

  std::string pgm(const GridOptions& options) const {
    std::string text = "P5\n" + std::to_string(columns_) + " " + std::to_string(rows_) + "\n255\n";
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
      const std::uint8_t value = obstacles_[i] >= options.min_points ? kOccupied
                                 : ground_[i] != 0                   ? kFree
                                                                     : kUnknown;
      text += static_cast<char>(value);
    }
    return text;
  }

  std::string yaml() const {
    char text[256];
    std::snprintf(text, sizeof text,
                  "image: grid.pgm\nresolution: %.9g\norigin: [%.6f, %.6f, 0.0]\nnegate: 0\n"
                  "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                  cell_, x_min_, y_min_);
    return text;
  }

 private:
  double cell_;
  double x_min_;
  double y_min_;
  int columns_;
  int rows_;
  std::vector<int> obstacles_;
  std::vector<char> ground_;
};

}  // namespace

Files save_grid(const PointCloud& map, const GridOptions& options,
                const std::filesystem::path& directory) {
  if (map.empty()) throw InputError("the map has no points; there is no grid to make");
  const PlacedPoints points(map, Pose());
  constexpr float kAll = std::numeric_limits<float>::infinity();
  LocalGround ground(points, kAll);
  ground.add(ground_columns(points, kAll));
  Cells cells(map, options.cell);
  for (std::size_t i = 0; i < points.size(); ++i) {
    cells.add(map.points[i], ground.height_above(points, i), options);
  }
  const Files files = {directory / "grid.pgm", directory / "grid.yaml"};
  write_text_atomically(files[0], cells.pgm(options));
  write_text_atomically(files[1], cells.yaml());
  return files;
}

}  // namespace lidar_mapping::map
