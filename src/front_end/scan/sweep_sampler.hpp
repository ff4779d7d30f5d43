// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "lidar_mapping/front_end/front_end_config.hpp"

#include "matching/ndt_types.hpp"
#include "scan/ring_interpolator.hpp"
#include "scan/scan_sampler.hpp"

namespace lidar_mapping::front_end {

/// Edge length of the cubes that give one point each: as configured, or smaller if the configured
/// one gives too few points, as in rooms and for sensors with few rings.
class AdaptiveCell {
 public:
  AdaptiveCell(double largest, double wanted_points)
      : largest_(largest), wanted_points_(wanted_points), edge_(largest) {}

  double edge() const { return edge_; }
  /// Adapts the edge to the number of points that it gave.
  void adapt(std::size_t points);

 private:
  double largest_;
  double wanted_points_;
  double edge_;
};

/// Samples a scan: few points for matching, and many points for the map.
class SweepSampler {
 public:
  explicit SweepSampler(const FrontEndConfig& config);

  /// Tells that points are measured from the origin of their frame.
  void set_viewpoint_at_origin();
  /// Sets the angle by which all points are rotated upwards from now on, rad.
  void set_elevation_shift(double angle) { elevation_shift_ = angle; }
  /// Samples the points to be matched; `phase` makes each scan start with another point.
  void sample(const Scan& scan, std::size_t phase);
  /// Leaves the marked ones of these points out.
  void leave_out(const PointMarks& marks);
  /// True if points of this scan were left out.
  bool leaves_out_points() const { return leaves_out_points_; }
  const NdtPoints& points() const { return points_; }
  /// The same points in the order in which they were sampled.
  const SampledPoints& sparse() const { return sparse_; }
  /// The reference time of the points: the middle of the sweep, s after the stamp.
  double reference() const { return reference_; }
  /// How long the sweep took, s; 0 for points without times.
  double duration() const { return duration_; }
  /// Median distance of the sampled points, m; 0 without points.
  double median_range() const;
  /// Samples the points for the map, from the scan for which sample() was called last; valid until
  /// the next call.
  const SampledPoints& sample_dense(const Scan& scan);
  /// Leaves the marked ones of those points out.
  void leave_out_of_dense(const PointMarks& marks) { dense_.remove(marks); }
  /// Interpolates points between the rings of the scan for which sample_dense() was called last.
  /// Valid until the next call.
  const SampledPoints& sample_between_rings(const Scan& scan, RingSurfaces surfaces);
  const SampledPoints& between_rings() const { return between_rings_; }

 private:
  void sample_sparse_once(const Scan& scan, std::size_t phase);
  void sample_dense_once(const Scan& scan);
  void assign_points();

  AdaptiveCell sparse_cell_;
  AdaptiveCell dense_cell_;
  double max_range_;
  bool scattered_order_ = false;      ///< see SamplingOptions
  bool sparse_cell_adapted_ = false;  ///< the cell has adapted to a first scan
  bool dense_cell_adapted_ = false;
  bool leaves_out_points_ = false;
  ScanSampler sparse_sampler_;
  ScanSampler dense_sampler_;
  RingInterpolator ring_interpolator_;
  SampledPoints sparse_;
  SampledPoints dense_;
  SampledPoints between_rings_;
  NdtPoints points_;
  double reference_ = 0.0;
  double duration_ = 0.0;
  double elevation_shift_ = 0.0;
};

}  // namespace lidar_mapping::front_end
