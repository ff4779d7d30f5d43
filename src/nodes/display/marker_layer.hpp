// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <visualization_msgs/Marker.h>

#include "display/graph_markers.hpp"

namespace lidar_mapping::ros_border {

/// Height of the graph above the road, whose points would hide it, m. Chosen: also above cars.
constexpr double kMarkerLift = 3.0;

inline geometry_msgs::Point to_point(const Eigen::Vector3d& vector) {
  geometry_msgs::Point point;
  point.x = vector.x();
  point.y = vector.y();
  point.z = vector.z();
  return point;
}

inline std_msgs::ColorRGBA color(float red, float green, float blue) {
  std_msgs::ColorRGBA result;
  result.r = red;
  result.g = green;
  result.b = blue;
  result.a = 1.0F;
  return result;
}

inline void add_line(visualization_msgs::Marker& marker, const Eigen::Vector3d& begin,
                     const Eigen::Vector3d& end) {
  marker.points.push_back(to_point(begin));
  marker.points.push_back(to_point(end));
}

/// The markers of one namespace, one for each piece of the path that has any.
class MarkerLayer {
 public:
  using Marker = visualization_msgs::Marker;

  MarkerLayer(const std::string& name, int type, double size, const std_msgs::ColorRGBA& color,
              const std::string& frame, double lift = kMarkerLift,
              std::size_t per_piece = kKeyFramesPerMarker)
      : per_piece_(per_piece) {
    empty_.header.frame_id = frame;
    empty_.ns = name;
    empty_.type = type;
    empty_.action = Marker::ADD;
    empty_.pose.position.z = lift;
    empty_.pose.orientation.w = 1.0;
    empty_.scale.x = empty_.scale.y = empty_.scale.z = size;
    empty_.color = color;
  }

  Marker& piece_of(std::size_t number) {
    const auto id = static_cast<int>(number / per_piece_);
    Marker& marker = markers_.try_emplace(id, empty_).first->second;
    marker.id = id;
    return marker;
  }
  /// Its markers, which it has no more afterwards.
  std::vector<Marker> take() {
    std::vector<Marker> all;
    for (auto& [id, marker] : std::exchange(markers_, {})) all.push_back(std::move(marker));
    return all;
  }

 private:
  Marker empty_;  ///< what they have in common
  std::size_t per_piece_;
  std::map<int, Marker> markers_;
};

}  // namespace lidar_mapping::ros_border
