// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "lidar_mapping/simulation/world.hpp"

namespace lidar_mapping::simulation {

/// A ray in map; `direction` has length 1, `time` is the share of the frame's interval in [0, 1].
struct Ray {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Eigen::Vector3f direction = Eigen::Vector3f::UnitX();
  float time = 0.0F;
};

/// What a ray met first.
struct Hit {
  float range = -1.0F;  ///< m; negative if nothing was met
  float cosine = 0.0F;  ///< of the angle of incidence, 0 to 1
  Reflectivity reflectivity = 0;
  bool moving = false;  ///< the surface belongs to a mover
};

/// Casts rays into a world with Embree (Wald et al. 2014). Const and safe to use from many threads.
class RayCaster {
 public:
  explicit RayCaster(const World& world);
  ~RayCaster();

  /// Rays whose movers are at their places between `begin_s` and `end_s` (seconds after the drive's
  /// beginning), `ray.time` of the way. Each ray is followed from `min_range` to `max_range`.
  void cast(const std::vector<Ray>& rays, double begin_s, double end_s, float min_range,
            float max_range, std::vector<Hit>& hits) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::simulation
