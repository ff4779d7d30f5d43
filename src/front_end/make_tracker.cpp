#include "lidar_mapping/front_end/ndt_tracker.hpp"

namespace lidar_mapping::front_end {

std::unique_ptr<Tracker> make_tracker(const FrontEndConfig& config) {
  return std::make_unique<NdtTracker>(config);
}

}  // namespace lidar_mapping::front_end
