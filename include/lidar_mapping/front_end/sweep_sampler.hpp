#pragma once

#include <cstddef>

#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/front_end/scan_sampler.hpp"
#include "lidar_mapping/registration/ndt_points.hpp"

namespace lidar_mapping::front_end {

/// Takes from a scan the few points that are matched and the many that go into the map.
class SweepSampler {
 public:
  explicit SweepSampler(const FrontEndConfig& config);

  /// Samples the points to be matched; `turn` makes each scan begin with another point.
  void take(const Scan& scan, std::size_t turn);
  const registration::NdtPoints& points() const { return points_; }
  /// The reference time of the points: the middle of the sweep, s after the stamp.
  double reference() const { return reference_; }
  /// The points for the map, of the scan that was taken last; valid until the next call.
  const SampledPoints& dense(const Scan& scan);

 private:
  double scan_resolution_;
  double insertion_resolution_;
  double max_range_;
  ScanSampler sparse_sampler_;
  ScanSampler dense_sampler_;
  SampledPoints sparse_;
  SampledPoints dense_;
  registration::NdtPoints points_;
  double reference_ = 0.0;
};

}  // namespace lidar_mapping::front_end
