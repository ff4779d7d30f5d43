// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"

namespace lidar_mapping::loop_closing {

/// The result for one key frame.
struct LoopClosingResult {
  std::vector<Loop> loops;            ///< accepted loops
  std::vector<LoopVerdict> verdicts;  ///< one per matched candidate, accepted or not
};

/// Finds loops: pairs of key frames that observe the same location (doc/loop_closing.md).
/// Candidates come from optimised positions, from GNSS and from appearance. Each candidate is
/// verified by matching the key frame with a submap. This class decides whether two key frames
/// observe the same location; the back end decides whether the graph uses the loop. The class must
/// be called from one thread. It reads clouds from a CloudSource.
class LoopCloser {
 public:
  /// `clouds` must outlive this object. Appearances are stored in a temporary file without a name
  /// in `directory`. The constructor and process() throw FileError if the file cannot be used.
  LoopCloser(const LoopClosingConfig& config, CloudSource& clouds,
             const std::filesystem::path& directory = std::filesystem::temp_directory_path());
  ~LoopCloser();

  /// Sets the position of the LiDAR in base_link (m) for the free-space check. The default is the
  /// origin.
  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar);
  /// From now on, searches only for loops with key frames below this index: those of one drive are
  /// searched in another one, and not again in their own.
  void search_only_before(KeyFrameIndex end);
  /// Adds a key frame of an earlier run without searching for loops. After a restart, first all key
  /// frames are restored by increasing index, then the loops, positions and poses.
  void restore(const KeyFrame& key_frame);
  /// Adds the loops, positions and poses of the restored key frames.
  void restore(const std::vector<Loop>& loops, const std::vector<GnssPosition>& gnss,
               const KeyFramePoses& poses);
  /// Adds a loop of the map that this search did not find, such as a manual one.
  void add_loop(const Loop& loop);

  /// Updates the poses of key frames to those of the back end. They replace the poses predicted by
  /// odometry.
  void update_poses(const KeyFramePoses& poses);
  /// Adds a position whose stamp is that of a key frame; it may come before or after the key frame.
  void add_gnss(const GnssPosition& position);
  /// Adds a key frame and searches for loops if a search is due. `prepared` may hold data that were
  /// computed in advance; the rest is computed now. Throws InputError unless indices increase.
  LoopClosingResult process(const KeyFrame& key_frame, const PreparedKeyFrame& prepared = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::loop_closing
