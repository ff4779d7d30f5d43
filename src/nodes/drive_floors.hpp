// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <visualization_msgs/Marker.h>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/map/key_frame_track.hpp"

namespace lidar_mapping::ros_border {

/// The floors below key frames, of all that are found in scans. A floor may come before its key
/// frame or after it.
class DriveFloors {
 public:
  /// True if it is below a key frame that is known.
  bool add(const Floor& floor);
  void add_key_frame(KeyFrameIndex index, Stamp stamp);

  const std::map<KeyFrameIndex, Floor>& below() const { return below_; }

 private:
  std::map<Stamp, KeyFrameIndex> key_frames_;
  std::map<Stamp, Floor> waiting_;  ///< for their key frames
  std::map<KeyFrameIndex, Floor> below_;
};

/// Floors below key frames, namespace floors: a post down from the graph, and around its foot a
/// square of 2 m that lies in the plane that was found.
std::vector<visualization_msgs::Marker> floor_markers(const map::KeyFrameTrack& track,
                                                      const std::map<KeyFrameIndex, Floor>& floors,
                                                      const std::string& frame);

}  // namespace lidar_mapping::ros_border
