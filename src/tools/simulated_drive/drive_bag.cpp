// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>
#include <optional>

#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "recording/kitti_bag.hpp"
#include "simulated_drive/drive_output.hpp"

namespace lidar_mapping::tools {

namespace {

using namespace simulation;

constexpr char kSecondTopic[] = "/second/points";
constexpr char kSecondFrame[] = "second_link";
/// How much later the turns of the second LiDAR begin, ns. Chosen: a third of a turn, so that
/// nothing is in step.
constexpr Stamp kSecondPhase = 33'000'000;
constexpr Stamp kGnssDelay = 50'000'000;
const Eigen::Vector3d kAntennaError(1.2, -0.9, 0.0);  // m

/// Steps to which coordinates (m, a fifth of the range noise) and intensities in the bag are
/// rounded, so that their floats have zeros that lz4 can compress.
constexpr float kPointStep = 1.0F / 256.0F;
constexpr float kIntensityStep = 4.0F;

sensor_msgs::Imu imu_message(const ImuSample& sample) {
  sensor_msgs::Imu message = ros_border::to_message(sample, kImuFrame);
  if (sample.orientation) fill_diagonal(message.orientation_covariance, kOrientationNoise);
  fill_diagonal(message.angular_velocity_covariance, kGyroNoise);
  fill_diagonal(message.linear_acceleration_covariance, kAccelerometerNoise);
  return message;
}

/// The second LiDAR: a metre behind the first one and lower, looking backwards and downwards.
Pose T_lidar_second() {
  const Eigen::AngleAxisd backwards(kPi, Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd downwards(0.3, Eigen::Vector3d::UnitY());
  return {Eigen::Quaterniond(backwards * downwards), {-1.0, 0.0, -0.2}};
}

std::optional<Drive> second_lidar(const Drive& drive, const BagContent& content) {
  if (content.second_lidar.empty()) return std::nullopt;
  return drive.with_lidar(content.second_lidar, drive.mounting().T_base_lidar * T_lidar_second(),
                          kSecondPhase);
}

float rounded(float value, float step) { return std::round(value / step) * step; }

sensor_msgs::PointCloud2 cloud_message(const SimulatedScan& scan, const BagContent& content,
                                       const char* frame) {
  PointCloud cloud = scan.cloud;
  if (content.has(BagFault::kDeskewedTwice)) {
    preprocessing::set_times_from_azimuth(cloud, preprocessing::PreprocessingConfig());
  }
  if (content.has(BagFault::kNoPointTimes)) cloud.times.clear();
  for (Point& point : cloud.points) {
    point = {rounded(point.x, kPointStep), rounded(point.y, kPointStep),
             rounded(point.z, kPointStep), rounded(point.intensity, kIntensityStep)};
  }
  const std::string slash = content.has(BagFault::kLeadingSlash) ? "/" : "";
  const Stamp late = content.has(BagFault::kStampInTheMiddle) ? (scan.end - scan.stamp) / 2 : 0;
  const Stamp stamp = content.has(BagFault::kNoStamps) ? 0 : scan.stamp + late;
  return ros_border::to_message(cloud, stamp, slash + frame);
}

ImuSample with_fault(ImuSample sample, const BagContent& content) {
  if (content.has(BagFault::kImuInG)) sample.linear_acceleration /= kStandardGravity;
  if (content.has(BagFault::kGyroInDegrees)) sample.angular_velocity *= kDegPerRad;
  return sample;
}

VelocitySample with_fault(VelocitySample sample, const BagContent& content) {
  if (content.has(BagFault::kVelocityInKmh)) sample.linear *= 3.6;
  return sample;
}

GnssFix with_fault(GnssFix fix, const BagContent& content) {
  if (content.has(BagFault::kGnssLate)) fix.stamp += kGnssDelay;
  if (content.has(BagFault::kGnssTooConfident) && fix.covariance) *fix.covariance *= 0.01;
  return fix;
}

nav_msgs::Odometry truth_message(const Drive& drive, Stamp stamp) {
  const MotionState state = drive.trajectory().state(stamp);
  nav_msgs::Odometry message;
  message.header = ros_border::header_of(stamp, "map");
  message.child_frame_id = kBaseFrame;
  message.pose.pose = ros_border::to_message(state.T_map_base);
  Vector6d twist;
  twist << state.T_map_base.rotation.conjugate() * state.velocity_map, state.angular_velocity_base;
  message.twist.twist = ros_border::to_twist(twist);
  return message;
}

tf2_msgs::TFMessage extrinsics(const Drive& drive, const BagContent& content) {
  SensorMounting mounting = drive.mounting();
  if (content.has(BagFault::kAntennaElsewhere)) mounting.p_base_antenna += kAntennaError;
  const Stamp stamp = drive.trajectory().begin();
  const Pose T_base_antenna{Eigen::Quaterniond::Identity(), mounting.p_base_antenna};
  tf2_msgs::TFMessage message;
  message.transforms = {transform_message(mounting.T_base_lidar, kLidarFrame, stamp),
                        transform_message(mounting.T_base_imu, kImuFrame, stamp),
                        transform_message(T_base_antenna, kAntennaFrame, stamp)};
  if (!content.second_lidar.empty()) {
    message.transforms.push_back(
        transform_message(mounting.T_base_lidar * T_lidar_second(), kSecondFrame, stamp));
  }
  if (content.has(BagFault::kNoImuTransform)) {
    message.transforms.erase(message.transforms.begin() + 1);
  }
  return message;
}

/// Writes messages in the order of their delivery; small ones are kept until the scans before them
/// are written.
class BagWriter {
 public:
  explicit BagWriter(rosbag::Bag& bag) : bag_(bag) {}

  /// Queues `message`; it is written after all messages that are delivered before `delivery`.
  template <typename Message>
  void add(const char* topic, Stamp delivery, Message message) {
    message.header.seq = sequence_[topic]++;
    waiting_.emplace(delivery, [this, topic, delivery, message = std::move(message)] {
      bag_.write(topic, ros_border::to_ros(delivery), message);
    });
  }
  void write_latched(const char* topic, Stamp delivery, const tf2_msgs::TFMessage& message) {
    using Traits = ros::message_traits::DataType<tf2_msgs::TFMessage>;
    const auto header = boost::make_shared<ros::M_string>();
    *header = {
        {"latching", "1"},
        {"type", Traits::value()},
        {"md5sum", ros::message_traits::MD5Sum<tf2_msgs::TFMessage>::value()},
        {"message_definition", ros::message_traits::Definition<tf2_msgs::TFMessage>::value()}};
    bag_.write(topic, ros_border::to_ros(delivery), message, header);
  }
  void write_until(Stamp delivery) {
    const auto end = waiting_.upper_bound(delivery);
    for (auto it = waiting_.begin(); it != end; ++it) it->second();
    waiting_.erase(waiting_.begin(), end);
  }
  void write_rest() {
    for (const auto& [delivery, write] : waiting_) write();
  }

 private:
  rosbag::Bag& bag_;
  std::multimap<Stamp, std::function<void()>> waiting_;  ///< equal times keep their order
  std::map<std::string, std::uint32_t> sequence_;
};

void add_samples(BagWriter& writer, const Drive& drive, const BagContent& content) {
  if (content.imu) {
    for (const ImuSample& s : drive.imu()) {
      writer.add(kImuTopic, s.stamp, imu_message(with_fault(s, content)));
    }
  }
  if (content.velocity) {
    for (const VelocitySample& s : drive.velocity()) {
      writer.add(kVelocityTopic, s.stamp,
                 ros_border::to_message(with_fault(s, content), kImuFrame));
    }
  }
  if (content.gnss) {
    for (const GnssFix& fix : drive.gnss()) {
      writer.add(kFixTopic, fix.stamp,
                 ros_border::to_message(with_fault(fix, content), kAntennaFrame));
    }
  }
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Stamp stamp = drive.scan_stamp(i);
    writer.add("/ground_truth", stamp, truth_message(drive, stamp));
  }
}

void fill_bag(const Drive& drive, rosbag::Bag& bag, const BagContent& content, int threads) {
  BagWriter writer(bag);
  if (!content.has(BagFault::kNoTransforms)) {
    writer.write_latched("/tf_static", drive.trajectory().begin(), extrinsics(drive, content));
  }
  add_samples(writer, drive, content);
  if (content.lidar) {
    const std::optional<Drive> second = second_lidar(drive, content);
    for_each_scan(drive, threads, [&](std::size_t index, const SimulatedScan& scan) {
      writer.add(kCloudTopic, scan.end, cloud_message(scan, content, kLidarFrame));
      if (second && index < second->scan_count()) {
        const SimulatedScan other = second->scan(index);
        writer.add(kSecondTopic, other.end, cloud_message(other, content, kSecondFrame));
      }
      writer.write_until(scan.end);
    });
  }
  writer.write_rest();
}

}  // namespace

const std::map<std::string, BagFault>& bag_faults() {
  static const std::map<std::string, BagFault> faults = {
      {"imu_in_g", BagFault::kImuInG},
      {"gyro_in_degrees", BagFault::kGyroInDegrees},
      {"velocity_in_kmh", BagFault::kVelocityInKmh},
      {"no_point_times", BagFault::kNoPointTimes},
      {"deskewed_twice", BagFault::kDeskewedTwice},
      {"no_imu_transform", BagFault::kNoImuTransform},
      {"no_transforms", BagFault::kNoTransforms},
      {"no_stamps", BagFault::kNoStamps},
      {"stamp_in_the_middle", BagFault::kStampInTheMiddle},
      {"leading_slash", BagFault::kLeadingSlash},
      {"antenna_elsewhere", BagFault::kAntennaElsewhere},
      {"gnss_late", BagFault::kGnssLate},
      {"gnss_too_confident", BagFault::kGnssTooConfident}};
  return faults;
}

void write_bag(const Drive& drive, const std::string& path, const BagContent& content,
               int threads) {
  write_whole_bag(path, [&](rosbag::Bag& bag) { fill_bag(drive, bag, content, threads); });
}

}  // namespace lidar_mapping::tools
