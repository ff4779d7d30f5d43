// SPDX-License-Identifier: BSD-3-Clause
#include "display/drive_floors.hpp"

#include "display/marker_layer.hpp"

namespace lidar_mapping::ros_border {

namespace {

using visualization_msgs::Marker;

/// Number of floors that are kept without key frame, which may be seconds late. Chosen: those of a
/// minute and more at 10 Hz.
constexpr std::size_t kWaiting = 1000;
constexpr double kHalfEdge = 1.0;  // m, of a square on the floor; chosen: as wide as a car
/// Key frames in a marker. Chosen: fewer than with dots, because a floor has ten points.
constexpr std::size_t kPerPiece = 20;

void add_square(Marker& marker, const Pose& T_map_base, const Floor& floor) {
  const Eigen::Vector3d foot = -floor.offset * floor.normal;
  const Eigen::Vector3d left = floor.normal.cross(Eigen::Vector3d::UnitX()).normalized();
  const Eigen::Vector3d ahead = left.cross(floor.normal);
  const auto corner = [&](double x, double y) -> Eigen::Vector3d {
    return T_map_base * (foot + kHalfEdge * (x * ahead + y * left));
  };
  add_line(marker, T_map_base * foot,
           T_map_base.translation + Eigen::Vector3d(0.0, 0.0, kMarkerLift));
  add_line(marker, corner(1, 1), corner(1, -1));
  add_line(marker, corner(1, -1), corner(-1, -1));
  add_line(marker, corner(-1, -1), corner(-1, 1));
  add_line(marker, corner(-1, 1), corner(1, 1));
}

}  // namespace

bool DriveFloors::add(const Floor& floor) {
  if (!floor.found) return false;
  const auto key_frame = key_frames_.find(floor.stamp);
  if (key_frame != key_frames_.end()) {
    below_[key_frame->second] = floor;
    return true;
  }
  waiting_[floor.stamp] = floor;
  if (waiting_.size() > kWaiting) waiting_.erase(waiting_.begin());
  return false;
}

/// Key frames arrive in the order of their stamps, so older floors will get none.
void DriveFloors::add_key_frame(KeyFrameIndex index, Stamp stamp) {
  key_frames_[stamp] = index;
  const auto floor = waiting_.find(stamp);
  if (floor != waiting_.end()) below_[index] = floor->second;
  waiting_.erase(waiting_.begin(), waiting_.upper_bound(stamp));
}

std::vector<Marker> floor_markers(const map::KeyFrameTrack& track,
                                  const std::map<KeyFrameIndex, Floor>& floors,
                                  const std::string& frame) {
  MarkerLayer layer("floors", Marker::LINE_LIST, 0.06, color(0.2F, 0.85F, 0.85F), frame, 0.0,
                    kPerPiece);
  for (const KeyFramePose& pose : track.poses().poses) {
    const auto floor = floors.find(pose.index);
    if (floor == floors.end()) continue;
    add_square(layer.piece_of(pose.index), pose.T_map_base, floor->second);
  }
  return layer.take();
}

}  // namespace lidar_mapping::ros_border
