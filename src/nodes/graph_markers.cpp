#include "graph_markers.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

/// The graph floats above the road, whose points would hide it; bridges of loops above the path.
constexpr double kLift = 3.0;    // m
constexpr double kBridge = 3.0;  // m
/// Odometry sees least of the motion in tunnels, whose roof would hide what shows it.
constexpr double kOverRoofs = 10.0;  // m

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

/// One namespace: a marker for each piece that has something to show.
class Layer {
 public:
  Layer(std::string name, int type, double size, const std_msgs::ColorRGBA& color,
        std::string frame, double lift = kLift)
      : name_(std::move(name)),
        type_(type),
        size_(size),
        color_(color),
        frame_(std::move(frame)),
        lift_(lift) {}

  Marker& piece_of(std::size_t number) {
    const auto id = static_cast<int>(number / kKeyFramesPerMarker);
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
  std::map<int, Marker> markers_;
};

void add_line(Marker& marker, const Eigen::Vector3d& begin, const Eigen::Vector3d& end) {
  marker.points.push_back(to_point(begin));
  marker.points.push_back(to_point(end));
}

/// Posts on both key frames and a beam between them: seen also where both passes lie side by side
/// under the line of the path.
void add_bridge(Marker& marker, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d up(0.0, 0.0, kBridge);
  add_line(marker, from, from + up);
  add_line(marker, from + up, to + up);
  add_line(marker, to + up, to);
}

using Places = std::map<KeyFrameIndex, Eigen::Vector3d>;

template <typename AddLine>
void add_verdicts(const Verdicts& verdicts, const Places& places, const AddLine& add,
                  Layer& layer) {
  for (const auto& [pair, verdict] : verdicts) {
    const auto from = places.find(pair.first);
    const auto to = places.find(pair.second);
    if (from == places.end() || to == places.end()) continue;
    Marker& marker = layer.piece_of(pair.second);
    add(marker, from->second, to->second);
    marker.colors.resize(marker.points.size(), color_of(verdict.verdict));
  }
}

}  // namespace

std::vector<Marker> graph_markers(const map::KeyFrameTrack& track, const Verdicts& loops,
                                  const Verdicts& candidates, const std::string& frame) {
  Layer dots("key_frames", Marker::SPHERE_LIST, 0.5, color(0.9F, 0.9F, 0.95F), frame);
  Layer lines("odometry", Marker::LINE_LIST, 0.15, color(0.3F, 0.55F, 0.95F), frame);
  Layer poor("degenerate", Marker::LINE_LIST, 1.2, color(1.0F, 0.55F, 0.0F), frame, kOverRoofs);
  Layer bridges("loops", Marker::LINE_LIST, 0.8, color_of(Verdict::kAccepted), frame);
  Layer tried("candidates", Marker::LINE_LIST, 0.15, color_of(Verdict::kRefused), frame);
  Places places;
  std::uint32_t segment = 0;
  const Eigen::Vector3d* before = nullptr;
  for (const map::TrackedKeyFrame& key_frame : track.key_frames()) {
    const Eigen::Vector3d& place =
        places.emplace(key_frame.pose.index, key_frame.pose.T_map_base.translation).first->second;
    dots.piece_of(key_frame.pose.index).points.push_back(to_point(place));
    if (before != nullptr && key_frame.segment == segment) {
      add_line(lines.piece_of(key_frame.pose.index), *before, place);
      if (key_frame.degenerate) add_line(poor.piece_of(key_frame.pose.index), *before, place);
    }
    before = &place;
    segment = key_frame.segment;
  }
  add_verdicts(loops, places, add_bridge, bridges);
  add_verdicts(candidates, places, add_line, tried);
  std::vector<Marker> markers;
  for (Layer* layer : {&dots, &lines, &poor, &bridges, &tried}) layer->move_to(markers);
  return markers;
}

std::vector<Marker> gnss_markers(const std::vector<Eigen::Vector3d>& positions,
                                 const std::string& frame) {
  Layer layer("gnss", Marker::SPHERE_LIST, 0.6, color(0.25F, 0.9F, 0.35F), frame);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    layer.piece_of(i).points.push_back(to_point(positions[i]));
  }
  std::vector<Marker> markers;
  layer.move_to(markers);
  return markers;
}

}  // namespace lidar_mapping::ros_border
