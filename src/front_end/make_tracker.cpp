// SPDX-License-Identifier: BSD-3-Clause

#include "ndt_tracker.hpp"
#include "sliding_window_tracker.hpp"

namespace lidar_mapping::front_end {

bool is_sequential_ndt(const FrontEndConfig& config) {
  using registration::Method;
  return registration::implemented_by(config.registration.method) == Method::kNdt &&
         config.local_map_method == LocalMapMethod::kVoxels;
}

std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config) {
  if (is_sequential_ndt(config)) return std::make_unique<NdtTracker>(config);
  return std::make_unique<SlidingWindowTracker>(config);
}

}  // namespace lidar_mapping::front_end
