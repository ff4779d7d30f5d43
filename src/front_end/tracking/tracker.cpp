// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/tracker.hpp"

#include "judgement/step_origin.hpp"
#include "tracking/external_tracker.hpp"
#include "tracking/ndt_tracker.hpp"
#include "tracking/sliding_window_tracker.hpp"

namespace lidar_mapping::front_end {

Covariance6 Tracker::covariance_of_step(const TrackedScan& from, const TrackedScan& to) const {
  return step_covariance(from, to);
}

bool is_sequential_ndt(const FrontEndConfig& config) {
  using registration::Method;
  return config.odometry == OdometrySource::kLidar &&
         registration::implemented_by(config.registration.method) == Method::kNdt &&
         config.local_map_method == LocalMapMethod::kVoxels;
}

std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config) {
  if (config.odometry == OdometrySource::kExternal) return std::make_unique<ExternalTracker>();
  if (is_sequential_ndt(config)) return std::make_unique<NdtTracker>(config);
  return std::make_unique<SlidingWindowTracker>(config);
}

}  // namespace lidar_mapping::front_end
