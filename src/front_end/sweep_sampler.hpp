// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/registration/ndt_points.hpp"

#include "ring_bridges.hpp"
#include "scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Edge of the cubes of which each gives one point: as in the configuration, or smaller where that
/// gives too few points, as in rooms and for sensors with few rings.
class AdaptiveCell {
 public:
  AdaptiveCell(double largest, double wanted_points)
      : largest_(largest), wanted_points_(wanted_points), edge_(largest) {}

  double edge() const { return edge_; }
  /// Learns from the number of points that the present edge gave.
  void adapt(std::size_t points);

 private:
  double largest_;
  double wanted_points_;
  double edge_;
};

/// Takes from a scan the few points that are matched and the many that go into the map.
class SweepSampler {
 public:
  explicit SweepSampler(const FrontEndConfig& config);

  /// Points were seen from the origin of their frame.
  void set_viewpoint_at_origin();
  /// From now on all points are turned upwards by this angle, rad.
  void set_elevation_shift(double angle) { elevation_shift_ = angle; }
  /// Samples the points to be matched; `turn` makes each scan begin with another point.
  void sample(const Scan& scan, std::size_t phase);
  const registration::NdtPoints& points() const { return points_; }
  /// The same, in the order in which they were sampled.
  const SampledPoints& sparse() const { return sparse_; }
  /// The reference time of the points: the middle of the sweep, s after the stamp.
  double reference() const { return reference_; }
  /// How long the sweep took, s; 0 for points without times.
  double duration() const { return duration_; }
  /// Median distance of the sampled points, m; 0 without points.
  double median_range() const;
  /// The points for the map, of the scan that was taken last; valid until the next call.
  const SampledPoints& sample_dense(const Scan& scan);
  /// Points on the surfaces between the rings of the scan for which dense() was called last: what
  /// else goes into the map. Valid until the next call.
  const SampledPoints& sample_between_rings(const Scan& scan);
  const SampledPoints& between_rings() const { return between_rings_; }

 private:
  void sample_sparse_once(const Scan& scan, std::size_t phase);
  void sample_dense_once(const Scan& scan);

  AdaptiveCell sparse_cell_;
  AdaptiveCell dense_cell_;
  double max_range_;
  bool scattered_order_ = false;      ///< see SamplingOptions
  bool sparse_cell_adapted_ = false;  ///< the cell has adapted to a first scan
  bool dense_cell_adapted_ = false;
  ScanSampler sparse_sampler_;
  ScanSampler dense_sampler_;
  RingBridges bridges_;
  SampledPoints sparse_;
  SampledPoints dense_;
  SampledPoints between_rings_;
  registration::NdtPoints points_;
  double reference_ = 0.0;
  double duration_ = 0.0;
  double elevation_shift_ = 0.0;
};

}  // namespace lidar_mapping::front_end
