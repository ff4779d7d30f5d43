// SPDX-License-Identifier: BSD-3-Clause
#include "gis/geotiff_files.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <Eigen/Geometry>
#include <cpl_conv.h>
#include <gdal_priv.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "files/ept_file.hpp"
#include "files/millimetre_frame.hpp"
#include "files/point_spool.hpp"
#include "grid/grid_frame.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

// Pixels, by definition: the edge of a block that GDAL takes by default.
constexpr int kBlock = 256;
constexpr int kMaxStripes = 64;  // chosen: so many buffers of points are 90 MB

/// Rows of pixels, from north to south, and columns from west to east.
struct RasterFrame {
  RasterFrame(const Eigen::AlignedBox2d& area, double pixel_m)
      : pixel(pixel_m),
        west(std::floor(area.min().x() / pixel_m) * pixel_m),
        north((std::floor(area.max().y() / pixel_m) + 1.0) * pixel_m) {
    const double wide = std::floor((area.max().x() - west) / pixel) + 1.0;
    const double tall = std::floor((north - area.min().y()) / pixel) + 1.0;
    check_raster_size(wide, tall, "--pixel");
    columns = static_cast<int>(wide);
    rows = static_cast<int>(tall);
  }

  int column_of(double x) const {
    return std::clamp(static_cast<int>((x - west) / pixel), 0, columns - 1);
  }
  int row_of(double y) const {
    return std::clamp(static_cast<int>((north - y) / pixel), 0, rows - 1);
  }

  double pixel;  ///< Edge, m.
  double west;
  double north;
  int columns = 0;
  int rows = 0;
};

/// The points in the coordinates of the raster.
class ProjectedPoints {
 public:
  ProjectedPoints(const std::optional<GeodeticDatum>& datum, const fs::path& directory)
      : frame_(datum), points_(directory) {}

  void add(const MapTile& tile) {
    if (points_.size() == 0) frame_.set_offset_near(tile.origin);
    for (const Point& point : tile.cloud.points) {
      const Eigen::Vector3d p = frame_.projected(tile.origin + point.position().cast<double>());
      points_.add({frame_.millimetres(p), point.intensity, 0});
      area_.extend(p.head<2>());
    }
  }

  Eigen::Vector3d position(const StoredPoint& point) const {
    const auto& p = point.position;
    return frame_.offset() + kMillimetre * Eigen::Vector3d(p[0], p[1], p[2]);
  }
  const PointSpool& points() const { return points_; }
  RasterFrame raster(double pixel) const { return {area_, pixel}; }
  std::uint16_t epsg() const { return frame_.epsg(); }

 private:
  MillimetreFrame frame_;
  PointSpool points_;
  Eigen::AlignedBox2d area_;  ///< Around all points.
};

/// The pixels of some rows.
struct Stripe {
  explicit Stripe(std::size_t pixels)
      : height(pixels, std::numeric_limits<float>::quiet_NaN()),
        intensity(pixels),
        density(pixels) {}

  void add(std::size_t pixel, float z, float value) {
    // The comparison is false for NaN, which means that there is no point yet.
    if (!(z <= height[pixel])) height[pixel] = z;
    intensity[pixel] += value;
    density[pixel] += 1.0F;
  }

  /// From sums to what the files hold.
  void finish(double pixel_m) {
    for (std::size_t i = 0; i < density.size(); ++i) {
      intensity[i] /= density[i];  // NaN without points
      density[i] /= static_cast<float>(pixel_m * pixel_m);
    }
  }

  std::vector<float> height;     ///< The highest point, m.
  std::vector<float> intensity;  ///< Sum, then mean.
  std::vector<float> density;    ///< Points, then points for each square metre.
};

/// A GeoTIFF of one band of floats, written from the uppermost row on.
class Raster {
 public:
  Raster(const fs::path& path, const RasterFrame& frame, std::uint16_t epsg, bool has_gaps)
      : columns_(frame.columns) {
    GDALAllRegister();
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const char* options[] = {"TILED=YES",     "COMPRESS=DEFLATE", "PREDICTOR=3",
                             "NUM_THREADS=1", "BIGTIFF=IF_SAFER", nullptr};
    dataset_.reset(driver->Create(path.c_str(), frame.columns, frame.rows, 1, GDT_Float32,
                                  const_cast<char**>(options)));
    if (!dataset_) fail();
    double transform[] = {frame.west, frame.pixel, 0.0, frame.north, 0.0, -frame.pixel};
    dataset_->SetGeoTransform(transform);
    if (epsg != 0) dataset_->SetProjection(utm_wkt(epsg).c_str());
    if (has_gaps) {
      dataset_->GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
    }
  }

  void write(int row, std::vector<float>& pixels) {
    const int rows = static_cast<int>(pixels.size()) / columns_;
    if (dataset_->GetRasterBand(1)->RasterIO(GF_Write, 0, row, columns_, rows, pixels.data(),
                                             columns_, rows, GDT_Float32, 0, 0) != CE_None) {
      fail();
    }
  }
  void close() {
    CPLErrorReset();
    dataset_.reset();
    if (CPLGetLastErrorType() >= CE_Failure) fail();
  }

 private:
  struct Close {
    void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
  };

  [[noreturn]] static void fail() {
    throw FileError(std::string("cannot write a GeoTIFF: ") + CPLGetLastErrorMsg() +
                    "; check the free space");
  }

  int columns_;
  std::unique_ptr<GDALDataset, Close> dataset_;
};

/// The points sorted into stripes of whole blocks.
class Stripes {
 public:
  Stripes(const ProjectedPoints& points, const RasterFrame& frame, const fs::path& directory)
      : points_(points), frame_(frame) {
    const int blocks = (frame.rows + kBlock - 1) / kBlock;
    rows_ = kBlock * ((blocks + kMaxStripes - 1) / kMaxStripes);
    for (int row = 0; row < frame.rows; row += rows_) spools_.emplace_back(directory);
    points.points().for_each([&](std::size_t, const StoredPoint& point) {
      const int row = frame_.row_of(points_.position(point).y());
      spools_[row / rows_].add(point);
    });
  }

  std::size_t size() const { return spools_.size(); }
  int first_row(std::size_t i) const { return static_cast<int>(i) * rows_; }
  Stripe stripe(std::size_t i) const {
    const int rows = std::min(rows_, frame_.rows - first_row(i));
    Stripe stripe(static_cast<std::size_t>(rows) * static_cast<std::size_t>(frame_.columns));
    spools_[i].for_each([&](std::size_t, const StoredPoint& point) {
      const Eigen::Vector3d p = points_.position(point);
      const auto row = static_cast<std::size_t>(frame_.row_of(p.y()) - first_row(i));
      const auto column = static_cast<std::size_t>(frame_.column_of(p.x()));
      stripe.add(row * static_cast<std::size_t>(frame_.columns) + column, static_cast<float>(p.z()),
                 point.intensity);
    });
    stripe.finish(frame_.pixel);
    return stripe;
  }

 private:
  const ProjectedPoints& points_;
  const RasterFrame& frame_;
  int rows_ = 0;
  std::vector<PointSpool> spools_;
};

/// Calls `write` with temporary names of all files, which are renamed together at the end.
void write_all_atomically(const Files& files, Files temporary,
                          const std::function<void(const Files&)>& write) {
  if (temporary.size() == files.size()) return write(temporary);
  write_atomically(files[temporary.size()], [&](const fs::path& next) {
    Files more = temporary;
    more.push_back(next);
    write_all_atomically(files, more, write);
  });
}

void write_rasters(const ProjectedPoints& points, const RasterFrame& frame, const Stripes& stripes,
                   const Files& files) {
  Raster height(files[0], frame, points.epsg(), true);
  Raster intensity(files[1], frame, points.epsg(), true);
  Raster density(files[2], frame, points.epsg(), false);
  for (std::size_t i = 0; i < stripes.size(); ++i) {
    Stripe stripe = stripes.stripe(i);
    height.write(stripes.first_row(i), stripe.height);
    intensity.write(stripes.first_row(i), stripe.intensity);
    density.write(stripes.first_row(i), stripe.density);
  }
  height.close();
  intensity.close();
  density.close();
}

}  // namespace

std::string geotiff_obstacle() { return {}; }

Files write_geotiff(const TileSource& tiles, const std::optional<GeodeticDatum>& datum,
                    double pixel, const fs::path& directory) {
  ProjectedPoints points(datum, directory);
  tiles([&](const MapTile& tile) { points.add(tile); });
  if (points.points().size() == 0) throw InputError("the map has no points yet; drive first");
  const RasterFrame frame = points.raster(pixel);
  const Stripes stripes(points, frame, directory);
  const Files files = {directory / "height.tif", directory / "intensity.tif",
                       directory / "density.tif"};
  write_all_atomically(
      files, {}, [&](const Files& temporary) { write_rasters(points, frame, stripes, temporary); });
  return files;
}

}  // namespace lidar_mapping::map
