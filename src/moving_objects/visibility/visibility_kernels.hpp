// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace lidar_mapping::moving_objects {

/// Columns of 0.4 degrees: rotating sensors have points every 0.1 to 0.4 degrees. Chosen: narrower
/// ones have gaps, wider ones mix what stands side by side.
constexpr int kRangeImageColumns = 900;

/// Ranges are counted in units of 2 mm, chosen so that they fit into 16 bits. They are limited to 1
/// to kMaxUnit (128 m), which is three times as far as observers vote.
constexpr float kUnitsPerMeter = 512.0F;
constexpr int kMaxUnit = 65'534;

/// Interval of ranges that were observed in a direction: the nearest in the lower 16 bits, the
/// farthest in the upper.
using RangeInterval = std::uint32_t;
constexpr RangeInterval kUnobserved = 0;  ///< Unobserved: neither seen through nor hit.

/// Coordinates of points, an array for each.
struct PointArrays {
  const float* x;
  const float* y;
  const float* z;
};

/// Pose of a sensor with a range image, relative to the frame of the points: p_sensor =
/// R_sensor_points (p - p_points_sensor), with row-major R.
struct Viewpoint {
  float R_sensor_points[9];
  float p_points_sensor[3];
  float squared_max_range;  ///< Square of the largest distance of a vote, m^2.
  int first_row;            ///< First row of the image.
  int rows;

  /// Index of the pixel behind the last one; used for points out of range, above or below the
  /// image.
  int no_pixel() const { return rows * kRangeImageColumns; }
};

/// Points projected into the image, an array for each quantity: indices of pixels, and the nearest
/// and farthest range (in units) that count as a hit of the point.
struct ProjectedPixels {
  int* pixels;
  int* nearest;
  int* farthest;
};

/// Numbers of observations of points, an array for each.
struct VisibilityCounts {
  int* through;  ///< Observers that saw through the location.
  int* hits;     ///< Observers that saw something there.
};

/// The inner loops of the visibility tests, compiled for every processor, for AVX2 and for AVX-512.
/// All versions do the same operations in the same order and give the same bits.
struct VisibilityKernels {
  /// Directions of points from the origin as column, row and range (in units) of a range image.
  void (*project)(const PointArrays& points, std::size_t count, int* columns, int* rows,
                  int* ranges);
  /// Increments the counts of points in range; returns their number.
  int (*count_in_range)(const Viewpoint& view, const PointArrays& points, std::size_t count,
                        int* counts);
  /// Projects points into the image of a viewpoint, and decrements `remaining` for those in range.
  void (*project_into_view)(const Viewpoint& view, const PointArrays& points, std::size_t count,
                            const ProjectedPixels& targets, int* remaining);
  /// Compares projected points with the 3x3 windows around their pixels, and increments the counts.
  /// `ambiguous` is 1 if the single pixels have to be tested, else 0.
  void (*classify)(const RangeInterval* windows, const ProjectedPixels& targets, std::size_t count,
                   const VisibilityCounts& counts, int* ambiguous);
};

/// The fastest kernels that this processor can run.
const VisibilityKernels& visibility_kernels();
/// The kernels that run on every processor.
const VisibilityKernels& portable_visibility_kernels();
/// Null if compiler or processor do not support AVX2.
const VisibilityKernels* avx2_visibility_kernels();
/// Null if the compiler does not support AVX-512 or the processor is slow with it.
const VisibilityKernels* avx512_visibility_kernels();

}  // namespace lidar_mapping::moving_objects
