#include "map_viewer_display.hpp"

#include "lidar_mapping/ros/geometry_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

geometry_msgs::Point to_point(const Eigen::Vector3d& vector) {
  geometry_msgs::Point point;
  point.x = vector.x();
  point.y = vector.y();
  point.z = vector.z();
  return point;
}

std_msgs::ColorRGBA color(float red, float green, float blue) {
  std_msgs::ColorRGBA result;
  result.r = red;
  result.g = green;
  result.b = blue;
  result.a = 1.0F;
  return result;
}

std_msgs::ColorRGBA color_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return color(1.0F, 0.3F, 0.8F);
    case Verdict::kRefused:
      return color(0.95F, 0.15F, 0.1F);
    case Verdict::kUndecided:
      return color(0.95F, 0.85F, 0.1F);
  }
  return {};
}

/// The graph floats above the road, whose points would hide it.
constexpr double kLift = 3.0;  // m

Marker empty_marker(const std::string& name, int type, double size) {
  Marker marker;
  marker.ns = name;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.position.z = kLift;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = size;
  return marker;
}

Marker key_frame_dots(const KeyFramePoses& poses) {
  Marker marker = empty_marker("key_frames", Marker::SPHERE_LIST, 0.5);
  marker.color = color(0.9F, 0.9F, 0.95F);
  for (const KeyFramePose& pose : poses.poses) {
    marker.points.push_back(to_point(pose.T_map_base.translation));
  }
  return marker;
}

Marker odometry_lines(const KeyFramePoses& poses, const std::vector<std::uint32_t>& segments) {
  Marker marker = empty_marker("odometry", Marker::LINE_LIST, 0.15);
  marker.color = color(0.3F, 0.55F, 0.95F);
  for (std::size_t i = 1; i < poses.poses.size(); ++i) {
    if (segments[i] != segments[i - 1]) continue;
    marker.points.push_back(to_point(poses.poses[i - 1].T_map_base.translation));
    marker.points.push_back(to_point(poses.poses[i].T_map_base.translation));
  }
  return marker;
}

Marker loop_lines(const KeyFramePoses& poses, const std::vector<LoopVerdict>& loops,
                  const std::string& name, double width) {
  Marker marker = empty_marker(name, Marker::LINE_LIST, width);
  std::map<KeyFrameIndex, Eigen::Vector3d> places;
  for (const KeyFramePose& pose : poses.poses) places[pose.index] = pose.T_map_base.translation;
  for (const LoopVerdict& loop : loops) {
    const auto from = places.find(loop.from);
    const auto to = places.find(loop.to);
    if (from == places.end() || to == places.end()) continue;
    marker.points.push_back(to_point(from->second));
    marker.points.push_back(to_point(to->second));
    marker.colors.insert(marker.colors.end(), 2, color_of(loop.verdict));
  }
  return marker;
}

}  // namespace

nav_msgs::Path to_path(const KeyFramePoses& poses, const std::string& frame) {
  nav_msgs::Path path;
  path.header.frame_id = frame;
  for (const KeyFramePose& pose : poses.poses) {
    geometry_msgs::PoseStamped stamped;
    stamped.header.frame_id = frame;
    stamped.header.stamp = to_ros(pose.stamp);
    stamped.pose = to_message(pose.T_map_base);
    path.poses.push_back(stamped);
  }
  if (!path.poses.empty()) path.header.stamp = path.poses.back().header.stamp;
  return path;
}

visualization_msgs::MarkerArray to_markers(const map::KeyFrameTrack& track,
                                           const std::vector<LoopVerdict>& loops,
                                           const std::vector<LoopVerdict>& candidates,
                                           const std::string& frame) {
  const KeyFramePoses poses = track.poses();
  visualization_msgs::MarkerArray array;
  if (poses.poses.empty()) return array;
  array.markers = {key_frame_dots(poses), odometry_lines(poses, track.segments()),
                   loop_lines(poses, loops, "loops", 0.8),
                   loop_lines(poses, candidates, "candidates", 0.2)};
  for (Marker& marker : array.markers) {
    marker.header.frame_id = frame;
    marker.header.stamp = to_ros(poses.poses.back().stamp);
    if (marker.points.empty()) marker.action = Marker::DELETE;
  }
  return array;
}

}  // namespace lidar_mapping::ros_border
