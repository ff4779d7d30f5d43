#include "lidar_mapping/front_end/front_end_status.hpp"

namespace lidar_mapping::front_end {

const char* to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kDegenerate:
      return "degenerate";
    case TrackingState::kDegraded:
      return "degraded";
    case TrackingState::kLost:
      return "lost";
  }
  return "";
}

}  // namespace lidar_mapping::front_end
