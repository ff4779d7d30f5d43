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

  MarkerLayer(std::string name, int type, double size, const std_msgs::ColorRGBA& color,
              std::string frame, double lift = kMarkerLift,
              std::size_t per_piece = kKeyFramesPerMarker)
      : name_(std::move(name)),
        type_(type),
        size_(size),
        color_(color),
        frame_(std::move(frame)),
        lift_(lift),
        per_piece_(per_piece) {}

  Marker& piece_of(std::size_t number) {
    const auto id = static_cast<int>(number / per_piece_);
    const auto [entry, is_new] = markers_.try_emplace(id);
    if (is_new) fill(id, entry->second);
    return entry->second;
  }
  void move_to(std::vector<Marker>& all) {
    for (auto& [id, marker] : markers_) all.push_back(std::move(marker));
    markers_.clear();
  }

 private:
  void fill(int id, Marker& marker) const {
    marker.header.frame_id = frame_;
    marker.ns = name_;
    marker.id = id;
    marker.type = type_;
    marker.action = Marker::ADD;
    marker.pose.position.z = lift_;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = marker.scale.y = marker.scale.z = size_;
    marker.color = color_;
  }

  std::string name_;
  int type_;
  double size_;
  std_msgs::ColorRGBA color_;
  std::string frame_;
  double lift_;
  std::size_t per_piece_;
  std::map<int, Marker> markers_;
};

}  // namespace lidar_mapping::ros_border
