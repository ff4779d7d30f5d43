#include "bag_input.hpp"

#include <map>

#include <geometry_msgs/TwistStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

namespace lidar_mapping::tools {

namespace {

using pipeline::FramedSample;
using pipeline::Input;

/// As in mapping.launch.
const SensorTopics kUsual = {"/kitti/velo/pointcloud", "/kitti/oxts/imu", "/kitti/oxts/gps/vel",
                             "/kitti/oxts/gps/fix"};
/// Sensors are bolted on: what /tf says of them at the beginning stays.
const ros::Duration kFramesLook(20.0);

template <typename Message>
Input framed(const Message& message) {
  auto sample = ros_border::from_message(message);
  return FramedSample<decltype(sample)>{sample, ros_border::frame_name(message.header.frame_id)};
}

}  // namespace

class BagInput::Impl {
 public:
  Impl(const std::vector<std::string>& paths, const SensorTopics& wanted, std::string base_frame,
       const preprocessing::PreprocessingConfig& config)
      : config_(config), base_frame_(std::move(base_frame)) {
    for (const std::string& path : paths) open(path);
    topics_ = {
        topic_of(wanted.points, kUsual.points, "sensor_msgs/PointCloud2"),
        topic_of(wanted.imu, kUsual.imu, "sensor_msgs/Imu"),
        topic_of(wanted.velocity, kUsual.velocity, "geometry_msgs/TwistStamped"),
        topic_of(wanted.gnss, kUsual.gnss, "sensor_msgs/NavSatFix"),
    };
    if (topics_.points.empty()) {
      throw InputError(paths.front() + " has no sensor_msgs/PointCloud2; name another bag");
    }
    add_query(view_, {topics_.points, topics_.imu, topics_.velocity, topics_.gnss});
    read_frames();
    position_ = view_.begin();
  }

  std::optional<Input> next() try {
    while (position_ != view_.end()) {
      const rosbag::MessageInstance message = *position_;
      std::optional<Input> input = read(message);
      ++position_;
      if (input) return input;
    }
    return std::nullopt;
  } catch (const rosbag::BagException& error) {
    throw FileError("cannot read on in " + bags_.front()->getFileName() + ": " + error.what() +
                    "; try rosbag reindex");
  }

  Stamp begin() { return ros_border::from_ros(view_.getBeginTime()); }
  Stamp end() { return ros_border::from_ros(view_.getEndTime()); }
  const SensorTopics& topics() const { return topics_; }

  std::optional<Pose> T_base(const std::string& frame) const try {
    if (frame == base_frame_) return Pose::Identity();
    return ros_border::from_message(
        frames_.lookupTransform(base_frame_, frame, ros::Time(0)).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }

 private:
  void open(const std::string& path) try {
    bags_.push_back(std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read));
  } catch (const rosbag::BagException& error) {
    throw FileError("cannot read the bag " + path + ": " + error.what() + "; try rosbag reindex");
  }

  std::map<std::string, std::size_t> topics_of_type(const std::string& type) const {
    std::map<std::string, std::size_t> sizes;
    for (const auto& bag : bags_) {
      rosbag::View view(*bag, rosbag::TypeQuery(type));
      for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
        const std::string& topic = connection->topic;
        if (sizes.count(topic) == 0) sizes[topic] = count(topic);
      }
    }
    return sizes;
  }

  std::size_t count(const std::string& topic) const {
    std::size_t count = 0;
    for (const auto& bag : bags_) count += rosbag::View(*bag, rosbag::TopicQuery(topic)).size();
    return count;
  }

  std::string topic_of(const std::string& wanted, const std::string& usual,
                       const std::string& type) const {
    const auto sizes = topics_of_type(type);
    if (!wanted.empty() && sizes.count(wanted) == 0) {
      throw InputError("there is no topic " + wanted + " of type " + type +
                       " in the bags; rosbag info shows what there is");
    }
    if (!wanted.empty()) return wanted;
    if (sizes.count(usual) > 0) return usual;
    std::string best;
    for (const auto& [topic, size] : sizes) {
      if (best.empty() || size > sizes.at(best)) best = topic;
    }
    return best;
  }

  void add_query(rosbag::View& view, std::vector<std::string> topics) const {
    topics.erase(std::remove(topics.begin(), topics.end(), ""), topics.end());
    for (const auto& bag : bags_) view.addQuery(*bag, rosbag::TopicQuery(topics));
  }

  void read_frames() {
    rosbag::View fixed;
    add_query(fixed, {"/tf_static"});
    for (const rosbag::MessageInstance& message : fixed) add_frames(message);
    for (const auto& bag : bags_) {
      const ros::Time from = view_.getBeginTime();
      rosbag::View moving(*bag, rosbag::TopicQuery("/tf"), from, from + kFramesLook);
      for (const rosbag::MessageInstance& message : moving) add_frames(message);
    }
  }

  void add_frames(const rosbag::MessageInstance& message) {
    const auto frames = message.instantiate<tf2_msgs::TFMessage>();
    if (!frames) return;
    for (geometry_msgs::TransformStamped transform : frames->transforms) {
      transform.header.frame_id = ros_border::frame_name(transform.header.frame_id);
      transform.child_frame_id = ros_border::frame_name(transform.child_frame_id);
      frames_.setTransform(transform, "bag", message.getTopic() == "/tf_static");
    }
  }

  std::optional<Input> read(const rosbag::MessageInstance& message) const {
    if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) {
      return pipeline::RecordedScan{ros_border::from_ros(cloud->header.stamp), [cloud, this] {
                                      return ros_border::decode(*cloud, config_).scan;
                                    }};
    }
    if (const auto imu = message.instantiate<sensor_msgs::Imu>()) return framed(*imu);
    if (const auto twist = message.instantiate<geometry_msgs::TwistStamped>()) {
      return framed(*twist);
    }
    if (const auto fix = message.instantiate<sensor_msgs::NavSatFix>()) return framed(*fix);
    return std::nullopt;
  }

  preprocessing::PreprocessingConfig config_;
  std::string base_frame_;
  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  SensorTopics topics_;
  rosbag::View view_;
  rosbag::View::iterator position_;
  tf2::BufferCore frames_{ros::Duration(1e6)};
};

BagInput::BagInput(const std::vector<std::string>& paths, const SensorTopics& wanted,
                   const std::string& base_frame, const preprocessing::PreprocessingConfig& config)
    : impl_(std::make_unique<Impl>(paths, wanted, base_frame, config)) {}
BagInput::~BagInput() = default;

std::optional<Input> BagInput::next() { return impl_->next(); }
Stamp BagInput::begin() const { return impl_->begin(); }
Stamp BagInput::end() const { return impl_->end(); }
std::optional<Pose> BagInput::T_base(const std::string& frame_id) const {
  return impl_->T_base(frame_id);
}
const SensorTopics& BagInput::topics() const { return impl_->topics(); }

}  // namespace lidar_mapping::tools
