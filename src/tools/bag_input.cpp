#include "bag_input.hpp"

#include <algorithm>
#include <deque>
#include <iomanip>
#include <sstream>
#include <utility>

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/open_bag.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/recorded_frames.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/transform_odometry.hpp"

#include "bag_stream.hpp"

namespace lidar_mapping::tools {

namespace {

using pipeline::FramedSample;
using pipeline::Input;
using ros_border::SensorTopics;

/// Sensors are bolted on: what /tf says of them at the beginning stays.
const ros::Duration kFramesLook(20.0);

/// Simulators begin at 0, where a stamp of 0 is one.
const ros::Time kSimulatedUntil(1e6);

/// The stamp, or where the driver sets none the time of recording.
Stamp given_or_recorded(Stamp stamp, const ros::Time& recorded) {
  const bool is_missing = stamp == 0 && recorded > kSimulatedUntil;
  return is_missing ? ros_border::from_ros(recorded) : stamp;
}

template <typename Sample>
Input framed(ros_border::SensorInput<Sample> input, const ros::Time& recorded) {
  input.sample.stamp = given_or_recorded(input.sample.stamp, recorded);
  return FramedSample<Sample>{input.sample, ros_border::frame_name(input.frame_id)};
}

/// A cloud that was left where it lies in the recording.
struct RecordedCloud {
  sensor_msgs::PointCloud2 message;  ///< without the data
  ByteRange data;
  std::shared_ptr<const void> memory;
};

RecordedCloud read_cloud(const BagMessage& recorded) {
  RecordedCloud cloud;
  sensor_msgs::PointCloud2& message = cloud.message;
  ros::serialization::IStream stream = recorded.stream();
  stream.next(message.header);
  stream.next(message.height);
  stream.next(message.width);
  stream.next(message.fields);
  stream.next(message.is_bigendian);
  stream.next(message.point_step);
  stream.next(message.row_step);
  std::uint32_t length = 0;
  stream.next(length);
  cloud.data = {stream.advance(length), length};
  cloud.memory = recorded.memory;
  return cloud;
}

FileError unreadable(const std::string& path, const ros::Exception& error) {
  return FileError("cannot read the bag " + path + ": " + error.what() + "; try rosbag reindex");
}

}  // namespace

/// Looks at the bags with rosbag, and reads them with a stream.
class BagInput::Impl {
 public:
  Impl(const std::vector<std::string>& paths, const SensorTopics& wanted,
       const std::string& base_frame, const preprocessing::PreprocessingConfig& config)
      : paths_(paths), config_(config), frames_(base_frame) {
    for (const std::string& path : paths) bags_.push_back(ros_border::open_bag(path));
    topics_ = ros_border::topics_in(all_bags(), wanted);
    read_frames();
    settle_base_frame();
    if (config.enable_robot_odometry_init_guess) {
      topics_.velocity.clear();
      wheels_.emplace(config.robot_odom_frame_id, frames_.base_frame());
    }
    rosbag::View all;
    add_query(all, sensor_topics());
    begin_ = ros_border::from_ros(all.getBeginTime());
    end_ = ros_border::from_ros(all.getEndTime());
  }

  std::optional<Input> next() {
    if (!waiting_.empty()) return take_waiting();
    while (const auto message = stream().next()) {
      mention_damage();
      if (auto input = readable(*message)) return input;
    }
    if (std::exchange(ended_, true) || damaged() == 0) return std::nullopt;
    mention_damage();
    notices_.push_back("damaged places of the recording that were left out: " +
                       std::to_string(damaged()));
    return std::nullopt;
  }

  std::vector<std::string> take_notices() { return std::exchange(notices_, {}); }

  std::vector<preprocessing::InputReport> examine(double seconds) const try {
    return ros_border::check({all_bags(), topics_, frames_.base_frame(), seconds}, config_);
  } catch (const rosbag::BagException& error) {
    throw unreadable(bags_.front()->getFileName(), error);
  }

  void skip_to(Stamp stamp) { stream().skip_to(stamp); }

  Stamp begin() const { return begin_; }
  Stamp end() const { return end_; }
  const SensorTopics& topics() const { return topics_; }
  const std::string& frames_notice() const { return frames_notice_; }
  std::optional<Pose> T_base(const std::string& frame) const { return frames_.T_base(frame); }

 private:
  std::vector<std::string> sensor_topics() const {
    return {topics_.points, topics_.imu, topics_.velocity, topics_.gnss};
  }
  std::vector<std::string> wanted_topics() const {
    std::vector<std::string> topics = sensor_topics();
    if (wheels_) topics.emplace_back("/tf");
    return topics;
  }

  /// With it, rosbag's index is let go: it grows with the recording.
  BagStream& stream() {
    if (!stream_) {
      stream_.emplace(paths_, wanted_topics());
      bags_.clear();
    }
    return *stream_;
  }

  std::vector<const rosbag::Bag*> all_bags() const {
    std::vector<const rosbag::Bag*> bags;
    for (const auto& bag : bags_) bags.push_back(bag.get());
    return bags;
  }

  void add_query(rosbag::View& view, const std::vector<std::string>& topics) const {
    for (const auto& bag : bags_) view.addQuery(*bag, rosbag::TopicQuery(topics));
  }

  void read_frames() {
    rosbag::View fixed;
    add_query(fixed, {"/tf_static"});
    for (const rosbag::MessageInstance& message : fixed) add_frames(message);
    const ros::Time from = begin_of(topics_.points);
    rosbag::View moving;
    for (const auto& bag : bags_) {
      moving.addQuery(*bag, rosbag::TopicQuery("/tf"), from, from + kFramesLook);
    }
    for (const rosbag::MessageInstance& message : moving) add_frames(message);
  }

  /// Where nothing says where the LiDAR is on the vehicle, its frame stands for the vehicle's.
  void settle_base_frame() {
    rosbag::View scans;
    add_query(scans, {topics_.points});
    if (scans.size() == 0) return;
    const auto cloud = scans.begin()->instantiate<sensor_msgs::PointCloud2>();
    if (!cloud) return;
    const std::string lidar_frame = ros_border::frame_name(cloud->header.frame_id);
    if (frames_.T_base(lidar_frame)) return;
    frames_notice_ = lidar_frame.empty() ? "the scans name no frame"
                                         : "nothing in the recording leads from '" + lidar_frame +
                                               "' to '" + frames_.base_frame() + "'";
    frames_notice_ +=
        ": the frame of the scans stands for that of the vehicle (x forward, z up), and sensors in "
        "frames without a transform to it are not used";
    if (!lidar_frame.empty()) frames_.set_base_frame(lidar_frame);
  }

  preprocessing::RawScan decoded(const RecordedCloud& cloud, Stamp stamp, PointCloud buffer) const {
    const ros_border::CloudView view(cloud.message, cloud.data.first, cloud.data.size);
    preprocessing::RawScan scan =
        ros_border::decode_lazily(view, cloud.memory, config_, std::move(buffer)).scan;
    scan.stamp = stamp;
    if (scan.frame_id.empty()) scan.frame_id = frames_.base_frame();
    return scan;
  }

  ros::Time begin_of(const std::string& topic) const {
    rosbag::View view;
    add_query(view, {topic});
    return view.size() == 0 ? ros::TIME_MIN : view.getBeginTime();
  }

  void add_frames(const rosbag::MessageInstance& message) {
    if (const auto frames = message.instantiate<tf2_msgs::TFMessage>()) {
      frames_.add(*frames, message.getTopic() == "/tf_static");
    }
  }

  std::size_t damaged() const { return stream_->damage().places + damaged_messages_; }

  /// The first that is met; of the others, the number is told at the end.
  void mention_damage() {
    const BagDamage& damage = stream_->damage();
    if (damage.places == 0 || std::exchange(damage_mentioned_, true)) return;
    std::ostringstream text;
    text << std::fixed << std::setprecision(3) << damage.reason << "; what was recorded at "
         << to_seconds(damage.first) << " s is left out";
    notices_.push_back(text.str());
  }

  std::optional<Input> take_waiting() {
    std::optional<Input> input(std::move(waiting_.front()));
    waiting_.pop_front();
    return input;
  }

  /// A message of /tf may hold several poses.
  std::optional<Input> read_wheels(const tf2_msgs::TFMessage& message) {
    for (const VelocitySample& sample : wheels_->add(message)) {
      waiting_.push_back(FramedSample<VelocitySample>{sample, frames_.base_frame()});
    }
    return waiting_.empty() ? std::nullopt : take_waiting();
  }

  std::optional<Input> readable(const BagMessage& message) try {
    if (wheels_) {
      if (const auto frames = message.instantiate<tf2_msgs::TFMessage>()) {
        return read_wheels(*frames);
      }
    }
    return read(message);
  } catch (const ros::Exception&) {
    ++damaged_messages_;
    return std::nullopt;
  }

  std::optional<Input> read(const BagMessage& message) const {
    const ros::Time recorded = ros_border::to_ros(message.recorded);
    if (message.holds<sensor_msgs::PointCloud2>()) {
      const RecordedCloud cloud = read_cloud(message);
      const Stamp stamp =
          given_or_recorded(ros_border::from_ros(cloud.message.header.stamp), recorded);
      return pipeline::RecordedScan{stamp, [cloud, stamp, this](PointCloud buffer) {
                                      return decoded(cloud, stamp, std::move(buffer));
                                    }};
    }
    if (const auto imu = message.instantiate<sensor_msgs::Imu>()) {
      return framed(ros_border::input_of(*imu), recorded);
    }
    if (auto velocity = ros_border::read_velocity(message)) return framed(*velocity, recorded);
    if (auto fix = ros_border::read_gnss(message)) return framed(*fix, recorded);
    return std::nullopt;
  }

  std::vector<std::string> paths_;
  preprocessing::PreprocessingConfig config_;
  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  SensorTopics topics_;
  ros_border::RecordedFrames frames_;
  std::string frames_notice_;
  std::optional<ros_border::TransformOdometry> wheels_;  ///< where the velocity comes from tf
  std::deque<Input> waiting_;                            ///< of a message that held several
  Stamp begin_ = 0;
  Stamp end_ = 0;
  std::optional<BagStream> stream_;
  std::size_t damaged_messages_ = 0;  ///< whole, but not what their type says
  bool damage_mentioned_ = false;
  bool ended_ = false;
  std::vector<std::string> notices_;
};

BagInput::BagInput(const std::vector<std::string>& paths, const SensorTopics& wanted,
                   const std::string& base_frame, const preprocessing::PreprocessingConfig& config)
    : impl_(std::make_unique<Impl>(paths, wanted, base_frame, config)) {}
BagInput::~BagInput() = default;

std::optional<Input> BagInput::next() { return impl_->next(); }
std::vector<std::string> BagInput::take_notices() { return impl_->take_notices(); }
void BagInput::skip_to(Stamp stamp) { impl_->skip_to(stamp); }
Stamp BagInput::begin() const { return impl_->begin(); }
Stamp BagInput::end() const { return impl_->end(); }
std::optional<Pose> BagInput::T_base(const std::string& frame_id) const {
  return impl_->T_base(frame_id);
}
const SensorTopics& BagInput::topics() const { return impl_->topics(); }
const std::string& BagInput::frames_notice() const { return impl_->frames_notice(); }
std::vector<preprocessing::InputReport> BagInput::examine(double seconds) const {
  return impl_->examine(seconds);
}

}  // namespace lidar_mapping::tools
