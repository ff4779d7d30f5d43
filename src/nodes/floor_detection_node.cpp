// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/floor_detector.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/transforms.hpp"

namespace lidar_mapping::ros_border {

/// Subscribed: synced_cloud, tf. Published: floor for every scan, also if none is found; for
/// subscribers floor_filtered_points (in which the floor is searched) and floor_points (on its
/// plane).
class FloorDetectionNode {
 public:
  using Config = NodeConfig<preprocessing::FloorDetectionConfig>;

  FloorDetectionNode(const Config& config, NodeContext& context)
      : config_(config),
        context_(context),
        stage_(config.stage),
        floor_(context.node.advertise<FloorMessage>("floor", kPublisherQueue)),
        filtered_points_(
            context.node.advertise<sensor_msgs::PointCloud2>("floor_filtered_points", 1)),
        floor_points_(context.node.advertise<sensor_msgs::PointCloud2>("floor_points", 1)),
        cloud_(subscribe_numbered<sensor_msgs::PointCloud2>(
            context, "synced_cloud", config.node.queue_size,
            [this](const auto& message) { process(*message); })) {}

 private:
  void process(const sensor_msgs::PointCloud2& message) {
    const Pose T_base_scan =
        sensor_frames_.required(config_.node.base_frame, message.header.frame_id);
    const Scan scan{from_ros(message.header.stamp),
                    transformed(from_message(message), T_base_scan)};
    context_.diagnostics.count_input(scan.stamp);
    const bool is_watched =
        filtered_points_.getNumSubscribers() > 0 || floor_points_.getNumSubscribers() > 0;
    preprocessing::FloorPoints points;
    const Floor floor = stage_.process(scan, is_watched ? &points : nullptr);
    floor_.publish(to_message(floor, config_.node.base_frame));
    if (is_watched) {
      filtered_points_.publish(to_message(points.filtered, scan.stamp, config_.node.base_frame));
      floor_points_.publish(to_message(points.inliers, scan.stamp, config_.node.base_frame));
    }
    context_.diagnostics.count_output(scan.stamp);
    ++(floor.found ? found_ : missing_);
    context_.diagnostics.set_state(Diagnostics::Level::kOk,
                                   floor.found ? "floor found" : "no floor in this scan");
    context_.diagnostics.set("scans with floor", found_);
    context_.diagnostics.set("scans without floor", missing_);
  }

  Config config_;
  NodeContext& context_;
  preprocessing::FloorDetector stage_;
  SensorFrames sensor_frames_;
  std::size_t found_ = 0;
  std::size_t missing_ = 0;
  ros::Publisher floor_, filtered_points_, floor_points_;
  ros::Subscriber cloud_;
};

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::FloorDetectionNode>(argc,
                                                                                            argv);
}
