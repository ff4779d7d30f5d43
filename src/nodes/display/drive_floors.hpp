// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <visualization_msgs/Marker.h>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::ros_border {

/// Selects the floors below key frames from those of all scans. A floor may arrive before or after
/// its key frame.
class DriveFloors {
 public:
  /// Adds a floor; true if it is below a known key frame.
  bool add(const Floor& floor);
  void add_key_frame(KeyFrameIndex index, Stamp stamp);

  const std::map<KeyFrameIndex, Floor>& below() const { return below_; }

 private:
  std::map<Stamp, KeyFrameIndex> key_frames_;
  std::map<Stamp, Floor> waiting_;  ///< floors without key frame so far
  std::map<KeyFrameIndex, Floor> below_;
};

/// Floors below key frames, namespace floors: a post down from the graph, and around its foot a
/// square of 2 m in the plane of the floor.
std::vector<visualization_msgs::Marker> floor_markers(const map::KeyFrameTrack& track,
                                                      const std::map<KeyFrameIndex, Floor>& floors,
                                                      const std::string& frame);

}  // namespace lidar_mapping::ros_border
