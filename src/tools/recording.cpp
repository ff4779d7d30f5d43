#include "recording.hpp"

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/open_bag.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"

namespace lidar_mapping::tools {

namespace {

/// Frames of /tf_static: of each its parent and T_parent_frame.
using FrameTree = std::map<std::string, std::pair<std::string, Pose>>;

class BagRecording {
 public:
  BagRecording(const std::string& path, const std::string& topic)
      : bag_(ros_border::open_bag(path)) {
    rosbag::View frames(*bag_, rosbag::TopicQuery("/tf_static"));
    for (const rosbag::MessageInstance& message : frames) {
      add_frames(*message.instantiate<tf2_msgs::TFMessage>());
    }
    view_ = std::make_unique<rosbag::View>(
        *bag_, rosbag::TopicQuery(topic.empty() ? first_cloud_topic(path) : topic));
    for (const rosbag::MessageInstance& message : *view_) messages_.push_back(message);
    if (messages_.empty()) throw InputError(path + " has no message on " + topic);
  }

  std::size_t size() const { return messages_.size(); }

  Scan scan(std::size_t index) const {
    const auto message = messages_[index].instantiate<sensor_msgs::PointCloud2>();
    if (!message) throw InputError(messages_[index].getTopic() + " holds no PointCloud2");
    preprocessing::RawScan raw = ros_border::decode(*message, {}).scan;
    return {raw.stamp, transformed(without_empty_returns(raw.cloud), T_base(raw.frame_id))};
  }

  Eigen::Vector3d sensor_origin() const {
    const auto first = messages_.front().instantiate<sensor_msgs::PointCloud2>();
    if (!first) throw InputError(messages_.front().getTopic() + " holds no PointCloud2");
    return T_base(first->header.frame_id).translation;
  }

 private:
  std::string first_cloud_topic(const std::string& path) const {
    rosbag::View view(*bag_, rosbag::TypeQuery("sensor_msgs/PointCloud2"));
    if (view.begin() == view.end()) throw InputError(path + " has no PointCloud2");
    return view.begin()->getTopic();
  }

  void add_frames(const tf2_msgs::TFMessage& message) {
    for (const auto& t : message.transforms) {
      frames_[t.child_frame_id] = {t.header.frame_id, ros_border::from_message(t.transform)};
    }
  }

  /// Identity where no chain of frames leads to base_link.
  Pose T_base(std::string frame) const {
    Pose T_frame_sensor;
    while (frame != "base_link") {
      const auto known = frames_.find(frame);
      if (known == frames_.end()) return Pose::Identity();
      T_frame_sensor = known->second.second * T_frame_sensor;
      frame = known->second.first;
    }
    return T_frame_sensor;
  }

  /// Sensors put what they do not see into their origin, or make it NaN.
  static PointCloud without_empty_returns(const PointCloud& cloud) {
    PointCloud seen;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const float squared_range = cloud.points[i].position().squaredNorm();
      if (!std::isfinite(squared_range) || squared_range == 0.0F) continue;
      seen.points.push_back(cloud.points[i]);
      if (cloud.has_times()) seen.times.push_back(cloud.times[i]);
    }
    return seen;
  }

  std::unique_ptr<rosbag::Bag> bag_;
  FrameTree frames_;
  std::unique_ptr<rosbag::View> view_;
  std::vector<rosbag::MessageInstance> messages_;
};

Recording open_bag(const std::string& path, const std::string& topic) try {
  const auto bag = std::make_shared<const BagRecording>(path, topic);
  return {bag->size(), [bag](std::size_t index) { return bag->scan(index); }, bag->sensor_origin()};
} catch (const rosbag::BagException& error) {
  throw FileError("cannot read the bag " + path + ": " + error.what());
}

Recording open_folder(const std::string& path, const pipeline::KittiReading& reading) {
  const auto folder = std::make_shared<const pipeline::KittiFolder>(path, reading);
  return {folder->size(), [folder](std::size_t index) { return folder->scan(index); },
          Eigen::Vector3d::Zero()};
}

}  // namespace

Recording open_recording(const std::string& path, const std::string& topic,
                         const pipeline::KittiReading& reading) {
  return std::filesystem::is_directory(path) ? open_folder(path, reading) : open_bag(path, topic);
}

}  // namespace lidar_mapping::tools
