// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"

#include "grid/free_space.hpp"
#include "grid/grid_frame.hpp"
#include "grid/ground_raster.hpp"
#include "map_products.hpp"

namespace lidar_mapping::map {

namespace {

// Values of occupied, free and unknown, by the format of map_server (mode "trinary", and the
// thresholds that are written beside the picture).
constexpr std::uint8_t kOccupied = 0;
constexpr std::uint8_t kFree = 254;
constexpr std::uint8_t kUnknown = 205;

// Edge of a block, m and cells. One block at a time is in memory with all of its points. Chosen:
// bounds the memory; the second one counts where cells are smaller than 0.1 m.
constexpr double kBlockEdge = 400.0;
constexpr int kBlockCells = 4000;

/// Points in the cells of a block.
struct PointEvidence {
  explicit PointEvidence(std::size_t cells) : obstacles(cells), has_ground(cells) {}

  void add(std::size_t cell, double height, const GridOptions& options) {
    constexpr std::uint8_t kMaxCount = 255;  // by the format of a byte: counting ends there
    if (height < options.lowest) {
      has_ground[cell] = true;
    } else if (height <= options.highest && obstacles[cell] < kMaxCount) {
      ++obstacles[cell];
    }
  }

  std::vector<std::uint8_t> obstacles;  ///< Number of points at the height of obstacles.
  std::vector<bool> has_ground;
};

std::uint8_t cell_value(int obstacles, bool has_ground, bool passed, const GridOptions& options) {
  if (obstacles >= options.min_points) return kOccupied;
  // A single point may be the only one of a thin object; a ray that passed beside it does not make
  // the cell free.
  return has_ground || (passed && obstacles == 0) ? kFree : kUnknown;
}

/// The points of a block and those around it on which its ground depends.
PointCloud points_around(const CloudParts& map, const GridFrame& frame, const GridBlock& block) {
  constexpr double kMargin = static_cast<double>(GroundRaster::kSupportRadius);  // m
  const Eigen::Vector2d low(frame.x_of(block.column) - kMargin, frame.y_of(block.row) - kMargin);
  const Eigen::Vector2d high(frame.x_of(block.column + block.columns) + kMargin,
                             frame.y_of(block.row + block.rows) + kMargin);
  const CloudParts::Area area(low.cast<float>(), high.cast<float>());
  PointCloud cloud;
  map.for_each_near(area, [&](const PointCloud& part) {
    for (const Point& point : part.points) {
      if (area.contains(point.position().head<2>())) cloud.points.push_back(point);
    }
  });
  return cloud;
}

/// Values of the cells of a block, lowest row first.
std::vector<std::uint8_t> cell_values(const CloudParts& map, const GridFrame& frame,
                                      const GridBlock& block, const GridOptions& options,
                                      const std::optional<GridRays>& rays) {
  constexpr float kUnlimited = std::numeric_limits<float>::infinity();
  const PointCloud cloud = points_around(map, frame, block);
  if (cloud.empty()) return std::vector<std::uint8_t>(block.size(), kUnknown);
  const moving_objects::TransformedPoints points(cloud, Pose());
  const moving_objects::GroundArea area(points, kUnlimited);
  moving_objects::LocalGround ground(area);
  ground.add(moving_objects::ground_columns(points, kUnlimited));
  PointEvidence evidence(block.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int column = frame.column_of(cloud.points[i].x);
    const int row = frame.row_of(cloud.points[i].y);
    if (!block.contains(column, row)) continue;
    const float height = ground.height_above(points.z[i], area.column_of(i));
    evidence.add(block.index_of(column, row), static_cast<double>(height), options);
  }
  const GroundRaster raster(points, area, ground);
  FreeSpace space(frame, block, raster, options);
  if (rays) space.carve(*rays);
  std::vector<std::uint8_t> values(block.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = cell_value(evidence.obstacles[i], evidence.has_ground[i], space.passed(i), options);
  }
  return values;
}

/// The blocks of a grid, row by row.
class GridBlocks {
 public:
  GridBlocks(const CloudParts& map, const GridFrame& frame)
      : frame_(frame),
        edge_(std::clamp(static_cast<int>(kBlockEdge / frame.cell), 1, kBlockCells)),
        columns_((frame.columns + edge_ - 1) / edge_),
        rows_((frame.rows + edge_ - 1) / edge_),
        has_ground_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    map.for_each_point([&](const Point& point) { mark_around(point); });
  }

  std::size_t size() const { return has_ground_.size(); }
  /// Whether there are points in the block, or so near that its ground may be known from them.
  bool has_ground(std::size_t i) const { return has_ground_[i] != 0; }
  GridBlock at(std::size_t i) const {
    const int column = static_cast<int>(i) % columns_ * edge_;
    const int row = static_cast<int>(i) / columns_ * edge_;
    return {column, row, std::min(edge_, frame_.columns - column),
            std::min(edge_, frame_.rows - row)};
  }

 private:
  void mark_around(const Point& point) {
    const float radius = GroundRaster::kSupportRadius;
    const int first_column = block_of(frame_.column_of(point.x - radius), columns_);
    const int last_column = block_of(frame_.column_of(point.x + radius), columns_);
    const int first_row = block_of(frame_.row_of(point.y - radius), rows_);
    const int last_row = block_of(frame_.row_of(point.y + radius), rows_);
    for (int row = first_row; row <= last_row; ++row) {
      for (int column = first_column; column <= last_column; ++column) {
        has_ground_[row * columns_ + column] = 1;
      }
    }
  }
  /// Block of a cell, or the nearest one of so many.
  int block_of(int cell, int blocks) const { return std::clamp(cell / edge_, 0, blocks - 1); }

  const GridFrame& frame_;
  int edge_;  ///< Edge of a block in cells.
  int columns_;
  int rows_;
  std::vector<std::uint8_t> has_ground_;
};

/// A PGM picture that is written block by block; its first row is the uppermost one.
class PgmWriter {
 public:
  PgmWriter(const std::filesystem::path& path, const GridFrame& frame)
      : frame_(frame), file_(path, std::ios::binary | std::ios::trunc) {
    file_ << "P5\n" << frame.columns << " " << frame.rows << "\n255\n";
    begin_ = file_.tellp();
  }

  void write(const GridBlock& block, const std::vector<std::uint8_t>& values) {
    for (int i = 0; i < block.rows; ++i) {
      const std::streamoff line = frame_.rows - 1 - (block.row + i);
      file_.seekp(begin_ + line * frame_.columns + block.column);
      file_.write(reinterpret_cast<const char*>(values.data()) +
                      static_cast<std::ptrdiff_t>(i) * block.columns,
                  block.columns);
    }
  }

  /// Returns false if the file could not be written completely.
  bool close() {
    file_.close();
    return static_cast<bool>(file_);
  }

 private:
  const GridFrame& frame_;
  std::ofstream file_;
  std::streamoff begin_ = 0;
};

}  // namespace

Files write_grid(const CloudParts& map, const GridOptions& options,
                 const std::filesystem::path& directory, const std::optional<GridRays>& rays) {
  const GridFrame frame(map, options.cell);
  const GridBlocks blocks(map, frame);
  const Files files = {directory / "grid.pgm", directory / "grid.yaml"};
  write_atomically(files[0], [&](const std::filesystem::path& temporary) {
    PgmWriter image(temporary, frame);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const GridBlock block = blocks.at(i);
      image.write(block, blocks.has_ground(i) ? cell_values(map, frame, block, options, rays)
                                              : std::vector<std::uint8_t>(block.size(), kUnknown));
    }
    if (!image.close()) {
      throw FileError("cannot write " + files[0].string() + "; check the free space");
    }
  });
  write_text_atomically(files[1], frame.yaml());
  return files;
}

}  // namespace lidar_mapping::map
