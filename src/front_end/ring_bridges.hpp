// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scan_sampler.hpp"

namespace lidar_mapping::front_end {

struct BridgeOptions {
  double reference = 0.0;  ///< s after the stamp, from which times are counted
  double spacing = 0.4;    ///< m, of the points that are made
  double max_range = 1e4;  ///< m from the sensor
};

/// Points on the surfaces between the rings of a scan. What few rings show of a surface are lines,
/// which fit however the sensor nods. The surface lies where the points of neighbouring rings that
/// are seen in one direction go on straight from ring to ring.
class RingBridges {
 public:
  /// Replaces `points` by the points between the rings of a cloud that was seen from their
  /// viewpoint; by none if that is not known.
  void find(const PointCloud& cloud, const BridgeOptions& options, SampledPoints& points);

 private:
  static constexpr std::size_t kColumns = 360;

  /// A point relative to the sensor.
  struct RingPoint {
    Eigen::Vector3f p;
    float time;   ///< s after the stamp
    float slope;  ///< height over horizontal distance: that of its ring
  };
  /// Points that are seen in one direction, from the lowest ring to the highest.
  struct Column {
    const RingPoint* begin;
    const RingPoint* end;
  };

  void collect(const PointCloud& cloud, const Eigen::Vector3f& origin, double max_range);
  void sort_by_columns();
  Column column(std::size_t number);
  /// True of a point that lies on the line through those on the rings beside its own.
  static bool is_straight(const Column& column, const RingPoint* s);
  /// Adds the points between the rings of the column with this number, relative to the sensor.
  static void bridge(const Column& column, std::size_t number, float spacing,
                     SampledPoints& points);

  std::vector<RingPoint> ring_points_;
  std::vector<std::uint16_t> column_numbers_;  ///< the column of each
  std::vector<RingPoint> sorted_points_;       ///< the same points, column by column
  std::array<std::size_t, kColumns + 1> column_begins_{};
};

}  // namespace lidar_mapping::front_end
