// SPDX-License-Identifier: BSD-3-Clause
#include "recording.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"
#include "lidar_mapping/ros/recorded_frames.hpp"

namespace lidar_mapping::recordings {

namespace {

/// Frames of /tf_static: of each its parent and T_parent_frame.
using FrameTree = std::map<std::string, std::pair<std::string, Pose>>;

using ros_border::BagChunk;
using ros_border::BagEntry;
using ros_border::BagMessage;
using ros_border::BagSet;
using ros_border::BagTopic;
using ros_border::RecordedCloud;

class BagRecording {
 public:
  BagRecording(const std::string& path, const std::string& topic) : path_(path) {
    const std::string clouds = topic.empty() ? first_cloud_topic(path) : topic;
    bag_ = ros_border::open_chunked(path, std::vector<std::string>{clouds});
    add_frames();
    for (const BagChunk& chunk : bag_->chunks()) {
      for (const BagEntry& entry : bag_->entries(chunk)) messages_.push_back({chunk, entry});
    }
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const MessagePosition& a, const MessagePosition& b) {
                       return a.entry.recorded < b.entry.recorded;
                     });
    if (messages_.empty()) throw InputError(path + " has no message on " + clouds);
  }

  std::size_t size() const { return messages_.size(); }

  Scan scan(std::size_t index) const {
    const RecordedCloud cloud = cloud_at(index);
    preprocessing::RawScan raw = reader_.read(cloud).scan;
    return {raw.stamp, without_empty_returns(raw.cloud)};
  }

  Pose T_base_sensor() const {
    return T_base(ros_border::frame_name(cloud_at(0).message.header.frame_id));
  }

 private:
  struct MessagePosition {
    BagChunk chunk;
    BagEntry entry;
  };

  static std::string first_cloud_topic(const std::string& path) {
    const BagSet bags({path});
    for (const BagTopic& topic : bags.topics()) {
      if (ros_border::is_cloud(topic.type, topic.md5sum) && topic.messages > 0) return topic.name;
    }
    throw InputError(path + " has no clouds of points");
  }

  void add_frames() try {
    ros_border::BagStream messages({path_}, {"/tf_static"});
    while (const auto message = messages.next()) {
      const auto frames = ros_border::read_transforms(*message);
      if (!frames) continue;
      for (const auto& t : frames->transforms) {
        frames_[ros_border::frame_name(t.child_frame_id)] = {
            ros_border::frame_name(t.header.frame_id), ros_border::from_message(t.transform)};
      }
    }
  } catch (const ros::Exception&) {
    fail("a message on /tf_static is damaged");
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw FileError("cannot read " + path_ + ": " + reason + "; copy it again, or record it anew");
  }

  /// Chunks are read in the order of the messages, so one is kept.
  RecordedCloud cloud_at(std::size_t index) const {
    const MessagePosition& position = messages_[index];
    if (!content_.bytes || position.chunk.position != content_of_) {
      content_ = bag_->read(position.chunk, memory_);
      content_of_ = position.chunk.position;
    }
    const ros_border::StoredMessage stored = bag_->message(content_, position.entry);
    const BagMessage message{&bag_->connections().at(position.entry.connection),
                             position.entry.recorded, stored.data, stored.memory};
    try {
      if (auto cloud = ros_border::read_cloud(message)) return *cloud;
    } catch (const ros::Exception&) {
      fail("scan " + std::to_string(index) + " is damaged");
    }
    throw InputError(message.topic() + " holds no clouds of points");
  }

  /// Identity where no chain of frames leads to base_link.
  Pose T_base(std::string frame) const {
    Pose T_frame_sensor;
    for (std::size_t steps = 0; frame != "base_link"; ++steps) {
      const auto known = frames_.find(frame);
      if (known == frames_.end() || steps > frames_.size()) return Pose::Identity();  // or a cycle
      T_frame_sensor = known->second.second * T_frame_sensor;
      frame = known->second.first;
    }
    return T_frame_sensor;
  }

  /// Invalid points of sensors are at their origin or NaN.
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

  const ros_border::CloudReader reader_{preprocessing::PreprocessingConfig()};
  std::string path_;
  std::unique_ptr<ros_border::ChunkedRecording> bag_;
  FrameTree frames_;
  std::vector<MessagePosition> messages_;
  mutable ros_border::ChunkMemory memory_;
  mutable ros_border::ChunkContent content_;
  mutable std::uint64_t content_of_ = 0;
};

Recording open_bag(const std::string& path, const std::string& topic) {
  const auto bag = std::make_shared<const BagRecording>(path, topic);
  return {bag->size(), [bag](std::size_t index) { return bag->scan(index); }, bag->T_base_sensor()};
}

Recording open_folder(const std::string& path, const pipeline::KittiReadOptions& reading) {
  const auto folder = std::make_shared<const pipeline::KittiFolder>(path, reading);
  return {folder->size(), [folder](std::size_t index) { return folder->scan(index); },
          Pose::Identity()};
}

}  // namespace

Recording open_recording(const std::string& path, const std::string& topic,
                         const pipeline::KittiReadOptions& reading) {
  return std::filesystem::is_directory(path) ? open_folder(path, reading) : open_bag(path, topic);
}

}  // namespace lidar_mapping::recordings
