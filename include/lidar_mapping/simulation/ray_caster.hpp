// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/simulation/world.hpp"

namespace lidar_mapping::simulation {

/// A ray in the map frame.
struct Ray {
  /// Position of the sensor, m.
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  /// Unit vector.
  Eigen::Vector3f direction = Eigen::Vector3f::UnitX();
  float time = 0.0F;  ///< Instant as a fraction of the interval of the frame, 0 to 1.
};

/// First surface that a ray hits.
struct Hit {
  float range = -1.0F;            ///< Distance, m; negative if nothing was hit.
  float cosine = 0.0F;            ///< Cosine of the angle of incidence, 0 to 1.
  Reflectivity reflectivity = 0;  ///< Reflectivity of the surface.
  bool moving = false;            ///< The surface belongs to a mover.
};

/// Casts rays into a world with Embree (Wald et al. 2014). Const and safe to use from many threads.
class RayCaster {
 public:
  /// `world` must outlive this object.
  explicit RayCaster(const World& world);
  ~RayCaster();

  /// Casts rays; `hits` gets one entry per ray. A mover is at its interpolated pose between
  /// `begin_s` and `end_s` (seconds after the beginning of the drive), at the fraction `ray.time`.
  /// Each ray is followed from `min_range` to `max_range` (m).
  void cast(const std::vector<Ray>& rays, double begin_s, double end_s, float min_range,
            float max_range, std::vector<Hit>& hits) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::simulation
