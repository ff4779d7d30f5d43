// SPDX-License-Identifier: BSD-3-Clause
// The kernels of visibility_kernels.hpp; included by one file per instruction set. Loops have no
// branches, so that they are vectorised, and call no function that the linker could take from
// another file.

#include "lidar_mapping/common/fast_angle.hpp"
#include "lidar_mapping/common/units.hpp"

#include "visibility/visibility_kernels.hpp"

#define LIDAR_MAPPING_INLINE inline __attribute__((always_inline))

namespace lidar_mapping::moving_objects {
namespace {

// By geometry: the image is a full turn.
constexpr float kColumnsPerRadian = kRangeImageColumns / (2.0F * kPiFloat);
// Rows of 0.5 degrees. Chosen: a little more than the rings of 64 beams lie apart (0.4 degrees).
constexpr float kRowsPerRadian = 2.0F * 180.0F / kPiFloat;
// m, and m per m: by how much a range has to differ for a vote. Chosen: more than the errors of
// poses and ranges (5 cm and 0.1 degrees), less than the depth of a car.
constexpr float kMargin = 0.2F;
constexpr float kMarginPerRange = 0.02F;

/// Truncates; 0 for negative values and NaN.
LIDAR_MAPPING_INLINE int truncated(float value) {
  return static_cast<int>(value > 0.0F ? value : 0.0F);
}

struct Direction {
  int column;
  int row;
  float range;
};

LIDAR_MAPPING_INLINE Direction direction_of(float x, float y, float z) {
  const float squared = x * x + y * y;
  const float azimuth = fast_angle(y, x) + kPiFloat;
  const float elevation = fast_angle(z, __builtin_sqrtf(squared)) + kPiFloat;
  const int turned = truncated(azimuth * kColumnsPerRadian);
  return {turned < kRangeImageColumns ? turned : turned - kRangeImageColumns,
          truncated(elevation * kRowsPerRadian), __builtin_sqrtf(squared + z * z)};
}

LIDAR_MAPPING_INLINE int units_of(float range) {
  constexpr auto kLargest = static_cast<float>(kMaxUnit);  // units
  const float units = range * kUnitsPerMeter;
  const float low = units > 1.0F ? units : 1.0F;
  return static_cast<int>(low < kLargest ? low : kLargest);
}

LIDAR_MAPPING_INLINE int nearest_of(RangeInterval interval) {
  return static_cast<int>(interval & 0xFFFFU);
}
LIDAR_MAPPING_INLINE int farthest_of(RangeInterval interval) {
  return static_cast<int>(interval >> 16U);
}

LIDAR_MAPPING_INLINE int is_within(int range, int nearest, int farthest) {
  return (range >= nearest ? 1 : 0) & (range <= farthest ? 1 : 0);
}

void project(const PointArrays& points, std::size_t count, int* __restrict columns,
             int* __restrict rows, int* __restrict ranges) {
  const PointArrays p = points;
  for (std::size_t i = 0; i < count; ++i) {
    const Direction direction = direction_of(p.x[i], p.y[i], p.z[i]);
    columns[i] = direction.column;
    rows[i] = direction.row;
    ranges[i] = units_of(direction.range);
  }
}

int count_in_range(const Viewpoint& view, const PointArrays& points, std::size_t count,
                   int* __restrict counts) {
  const Viewpoint v = view;
  const PointArrays p = points;
  int sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = p.x[i] - v.p_points_sensor[0];
    const float y = p.y[i] - v.p_points_sensor[1];
    const float z = p.z[i] - v.p_points_sensor[2];
    const int is_near = x * x + y * y + z * z <= v.squared_max_range ? 1 : 0;
    counts[i] += is_near;
    sum += is_near;
  }
  return sum;
}

void project_into_view(const Viewpoint& view, const PointArrays& points, std::size_t count,
                       const ProjectedPixels& targets, int* __restrict remaining) {
  const Viewpoint v = view;
  const PointArrays p = points;
  const float* R = v.R_sensor_points;
  const int no_pixel = v.no_pixel();
  int* __restrict pixels = targets.pixels;
  int* __restrict nearest = targets.nearest;
  int* __restrict farthest = targets.farthest;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = p.x[i] - v.p_points_sensor[0];
    const float y = p.y[i] - v.p_points_sensor[1];
    const float z = p.z[i] - v.p_points_sensor[2];
    const int is_near = x * x + y * y + z * z <= v.squared_max_range ? 1 : 0;
    const Direction direction =
        direction_of(R[0] * x + R[1] * y + R[2] * z, R[3] * x + R[4] * y + R[5] * z,
                     R[6] * x + R[7] * y + R[8] * z);
    const int row = direction.row - v.first_row;
    const int is_in_image = is_near & (row >= 0 ? 1 : 0) & (row < v.rows ? 1 : 0);
    const float margin = kMargin + kMarginPerRange * direction.range;
    pixels[i] = is_in_image != 0 ? row * kRangeImageColumns + direction.column : no_pixel;
    nearest[i] = units_of(direction.range - margin);
    farthest[i] = units_of(direction.range + margin);
    remaining[i] -= is_near;
  }
}

void classify(const RangeInterval* __restrict windows, const ProjectedPixels& targets,
              std::size_t count, const VisibilityCounts& counts, int* __restrict ambiguous) {
  const int* __restrict pixels = targets.pixels;
  const int* __restrict nearest = targets.nearest;
  const int* __restrict farthest = targets.farthest;
  int* __restrict through = counts.through;
  int* __restrict hits = counts.hits;
  for (std::size_t i = 0; i < count; ++i) {
    const RangeInterval interval = windows[pixels[i]];
    const int observed_nearest = nearest_of(interval);
    const int observed_farthest = farthest_of(interval);
    const int is_free = observed_nearest > farthest[i] ? 1 : 0;
    const int is_hidden = observed_farthest < nearest[i] ? 1 : 0;
    const int is_hit = is_within(observed_nearest, nearest[i], farthest[i]) |
                       is_within(observed_farthest, nearest[i], farthest[i]);
    through[i] += is_free;
    hits[i] += is_hit;
    ambiguous[i] = 1 & ~(is_free | is_hidden | is_hit);
  }
}

constexpr VisibilityKernels kKernels = {project, count_in_range, project_into_view, classify};

}  // namespace
}  // namespace lidar_mapping::moving_objects
