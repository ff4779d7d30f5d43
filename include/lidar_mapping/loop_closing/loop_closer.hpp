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

struct LoopClosingResult {
  std::vector<Loop> loops;            ///< accepted ones
  std::vector<LoopVerdict> verdicts;  ///< of every candidate, accepted or not
};

/// Finds key frames that see a place again: candidates from the optimised positions, from GNSS and
/// from appearance, each verified by matching the key frame against a submap
/// (doc/loop_closing.md). It alone decides whether two key frames see the same place; whether the
/// graph believes it is the back end's business. One thread calls it; clouds come from the source.
class LoopCloser {
 public:
  /// `clouds` must outlive this object. What is not needed all the time is put aside in a nameless
  /// file in that folder. Throws FileError where that fails, also later.
  LoopCloser(const LoopClosingConfig& config, CloudSource& clouds,
             const std::filesystem::path& directory = std::filesystem::temp_directory_path());
  ~LoopCloser();

  /// Where the LiDAR sits in base_link (m), for the free-space check; the origin if never told.
  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar);
  /// After a restart: the key frames of before, in their order, and then what was known of them.
  /// Like process(), but without a search.
  void restore(const KeyFrame& key_frame);
  void restore(const std::vector<Loop>& loops, const std::vector<GnssPosition>& gnss,
               const KeyFramePoses& poses);
  /// A loop that the map holds and that this search did not find.
  void add_loop(const Loop& loop);

  /// The newest poses from the back end. They replace what odometry said of these key frames.
  void update_poses(const KeyFramePoses& poses);
  /// A position at the stamp of a key frame (before or after the key frame itself).
  void add_gnss(const GnssPosition& position);
  /// Takes a key frame in (indices increase) and searches for a loop when it is due. What was not
  /// prepared of its cloud is made now.
  LoopClosingResult process(const KeyFrame& key_frame, const PreparedKeyFrame& prepared = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::loop_closing
