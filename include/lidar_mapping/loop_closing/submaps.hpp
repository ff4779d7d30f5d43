#pragma once

#include <list>
#include <memory>
#include <optional>

#include "lidar_mapping/common/cloud_source.hpp"
#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/trajectory.hpp"
#include "lidar_mapping/loop_closing/verification.hpp"

namespace lidar_mapping::loop_closing {

/// Key frames that the scan to be matched is made of.
constexpr int kQueryKeyFrames = 3;

/// Makes what is matched: the scan of a key frame and the submap around another. Keeps a few
/// filtered clouds and submaps, so that memory does not grow with the drive.
class Submaps {
 public:
  /// Both must outlive this object.
  Submaps(const LoopClosingConfig& config, CloudSource& clouds);
  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar);

  /// Keeps the cloud of a new key frame and returns it filtered, in base_link; null if it is not to
  /// be had.
  PointCloudPtr take_newest(const KeyFrame& key_frame);
  /// The newest scan with those of the two nodes before, which a sensor of few beams needs.
  std::optional<QueryScan> query(const Trajectory& trajectory);
  /// The key frames within extend_frame_num of the node, as far as there are any on either side;
  /// null if the node's own cloud is not to be had.
  std::shared_ptr<const Submap> around(const Trajectory& trajectory, Trajectory::NodeId node);

 private:
  template <typename Value>
  struct Kept {
    KeyFrameIndex index;
    Value value;
  };
  PointCloudPtr map_cloud(KeyFrameIndex index);
  PointCloudPtr keep(KeyFrameIndex index, const PointCloud& cloud);
  PointCloud newest_scan(KeyFrameIndex index);
  PointCloud joined(const Trajectory& trajectory, Trajectory::NodeId middle, std::size_t before,
                    std::size_t after);

  LoopClosingConfig config_;
  CloudSource& clouds_;
  Eigen::Vector3f p_base_lidar_ = Eigen::Vector3f::Zero();
  PointCloudPtr newest_;
  std::list<Kept<PointCloudPtr>> kept_clouds_;                   // newest first
  std::list<Kept<std::shared_ptr<const Submap>>> kept_submaps_;  // newest first
};

}  // namespace lidar_mapping::loop_closing
