// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidar_mapping::moving_objects {

constexpr int kRangeImageColumns = 900;

/// Ranges are counted in units of 2 mm, so that a pixel is small. What is nearer than 1 is 1, and
/// what is farther than 128 m, three times as far as observers reach, is kFarthestUnit.
constexpr float kUnitsPerMeter = 512.0F;
constexpr int kFarthestUnit = 65'534;

/// The nearest range that was seen in a direction in the lower 16 bits, the farthest in the upper.
using Seen = std::uint32_t;
constexpr Seen kSeenHidden = 0;  ///< neither looked through nor hit

/// Coordinates of points, one array each.
struct PointArrays {
  const float* x;
  const float* y;
  const float* z;
};

/// A sensor with a range image, as seen from the frame of the points in question:
/// p_sensor = R_sensor_points (p - p_points_sensor), row-major R.
struct Viewpoint {
  float R_sensor_points[9];
  float p_points_sensor[3];
  float squared_reach;  ///< m^2
  int first_row;        ///< of the image
  int rows;

  /// Behind the last one; that of points out of reach, above or below the image.
  int no_pixel() const { return rows * kRangeImageColumns; }
};

/// Where to look for points, one array each: numbers of pixels, and the nearest and farthest range
/// at which something is taken for the point, in units.
struct ProjectedPixels {
  int* pixels;
  int* nearest;
  int* farthest;
};

/// What was said of points, one array each.
struct Counts {
  int* through;  ///< by how many the place was looked through
  int* hits;     ///< by how many something was seen there
};

/// The inner loops of looking into range images, compiled for every processor, for AVX2 and for
/// AVX-512. All do the same operations in the same order and give the same bits.
struct VisibilityKernels {
  /// Where points are seen from the origin in any range image: column, row and range in units.
  void (*project)(const PointArrays& points, std::size_t count, int* columns, int* rows,
                  int* ranges);
  /// Adds one to the counts of points in reach; returns how many there are.
  int (*count_reach)(const Viewpoint& view, const PointArrays& points, std::size_t count,
                     int* counts);
  /// Takes one from `left` of points in reach.
  void (*aim)(const Viewpoint& view, const PointArrays& points, std::size_t count,
              const ProjectedPixels& targets, int* left);
  /// windows: what was seen in the 3x3 pixels around each. Counts what that says; `unclear` is 1
  /// where the single pixels have to be asked, 0 elsewhere.
  void (*look)(const Seen* windows, const ProjectedPixels& targets, std::size_t count,
               const Counts& counts, int* unclear);
};

/// The fastest kernels that this processor can run.
const VisibilityKernels& visibility_kernels();
const VisibilityKernels& portable_visibility_kernels();
/// Null where the compiler or the processor knows no AVX2.
const VisibilityKernels* avx2_visibility_kernels();
/// Null where the compiler does not know AVX-512 or the processor is not fast with it.
const VisibilityKernels* avx512_visibility_kernels();

}  // namespace lidar_mapping::moving_objects
