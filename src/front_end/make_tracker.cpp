// SPDX-License-Identifier: BSD-3-Clause

#include "ndt_tracker.hpp"
#include "sliding_window_tracker.hpp"

namespace lidar_mapping::front_end {

std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config) {
  using registration::Method;
  const bool is_ndt = registration::implemented_by(config.registration.method) == Method::kNdt;
  if (is_ndt && config.local_map_method == LocalMapMethod::kVoxels) {
    return std::make_unique<NdtTracker>(config);
  }
  return std::make_unique<SlidingWindowTracker>(config);
}

}  // namespace lidar_mapping::front_end
