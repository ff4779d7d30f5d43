// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// On which surfaces points are interpolated.
enum class RingSurfaces {
  kAll,
  kGround,  ///< level ones below the sensor
};

struct RingInterpolationOptions {
  double reference = 0.0;  ///< s after the stamp, from which times are counted
  double spacing = 0.4;    ///< m, between the interpolated points
  double max_range = 1e4;  ///< m from the sensor
  RingSurfaces surfaces = RingSurfaces::kAll;
};

/// Interpolates points on the surfaces between the rings of a scan. A sensor with few rings shows
/// only lines of a surface, and these fit whatever the pitch of the sensor is. A surface is assumed
/// where the points of neighbouring rings in one direction lie on a straight line from ring to
/// ring.
class RingInterpolator {
 public:
  /// Replaces `points` by the interpolated points between the rings of a cloud that was measured
  /// from their viewpoint; by none if the viewpoint is not known.
  void interpolate(const PointCloud& cloud, const RingInterpolationOptions& options,
                   SampledPoints& points);

 private:
  /// Of 1 degree. Chosen: narrower ones may have no point of a ring, wider ones bridge corners.
  static constexpr std::size_t kColumns = 360;

  /// A point relative to the sensor.
  struct RingPoint {
    Eigen::Vector3f p;
    float time;   ///< s after the stamp
    float slope;  ///< height over horizontal distance, which is constant on a ring
  };
  /// Points in one horizontal direction, from the lowest ring to the highest.
  struct Column {
    const RingPoint* begin;
    const RingPoint* end;
  };

  void collect(const PointCloud& cloud, const Eigen::Vector3f& origin, double max_range);
  void sort_by_columns();
  Column column(std::size_t number);
  /// True if a point lies on the line through its neighbours on the rings above and below.
  static bool is_straight(const Column& column, const RingPoint* point);
  /// True if a surface is assumed between this point and the next one of its column.
  static bool has_surface(const Column& column, const RingPoint* point, RingSurfaces surfaces);
  /// Adds the interpolated points of the column with this number, relative to the sensor.
  static void interpolate_column(const Column& column, std::size_t number,
                                 const RingInterpolationOptions& options, SampledPoints& points);

  std::vector<RingPoint> ring_points_;
  std::vector<std::uint16_t> column_numbers_;  ///< the column of each point
  std::vector<RingPoint> sorted_points_;       ///< the same points, column by column
  std::array<std::size_t, kColumns + 1> column_begins_{};
};

}  // namespace lidar_mapping::front_end
