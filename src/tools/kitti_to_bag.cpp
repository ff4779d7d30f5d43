// SPDX-License-Identifier: BSD-3-Clause
// Writes a raw recording of KITTI, or a folder as its odometry benchmark lays it out, as a bag with
// the topics that mapping.launch expects.

#include <filesystem>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"
#include "lidar_mapping/pipeline/kitti_folder.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "command_line/number_checks.hpp"
#include "command_line/overwriting.hpp"
#include "command_line/progress_bar.hpp"
#include "command_line/run_command.hpp"
#include "recording/kitti_bag.hpp"

namespace {

using namespace lidar_mapping;
using namespace lidar_mapping::tools;

struct Options {
  std::string folder;
  std::string bag;
  std::string poses_enu;
  std::vector<double> datum = {49.0, 8.4, 110.0};
  double gnss_sigma = 0.05;
  double sensor_height = 1.73;
  double start = 1317617735.0;
};

/// Receiver and IMU have the frame of the poses: that of the LiDAR.
tf2_msgs::TFMessage extrinsics(const Options& options, Stamp stamp) {
  Pose T_base_lidar;
  T_base_lidar.translation.z() = options.sensor_height;
  tf2_msgs::TFMessage message;
  for (const char* frame : {kLidarFrame, kImuFrame, kAntennaFrame}) {
    message.transforms.push_back(transform_message(T_base_lidar, frame, stamp));
  }
  return message;
}

sensor_msgs::NavSatFix fix_at(const Eigen::Vector3d& p_enu, const Options& options, Stamp stamp) {
  const GeographicLib::LocalCartesian local(options.datum[0], options.datum[1], options.datum[2]);
  sensor_msgs::NavSatFix message;
  message.header = ros_border::header_of(stamp, kAntennaFrame);
  message.status.status = sensor_msgs::NavSatStatus::STATUS_GBAS_FIX;
  message.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  local.Reverse(p_enu.x(), p_enu.y(), p_enu.z(), message.latitude, message.longitude,
                message.altitude);
  fill_diagonal(message.position_covariance, options.gnss_sigma);
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
  return message;
}

sensor_msgs::Imu attitude_at(const Pose& T_enu_lidar, Stamp stamp) {
  constexpr double kSigma = 0.002;  // rad; chosen as of a good INS (0.1 degrees)
  ImuSample sample;
  sample.stamp = stamp;
  sample.orientation = T_enu_lidar.rotation;
  sample.linear_acceleration =
      T_enu_lidar.rotation.conjugate() * Eigen::Vector3d(0.0, 0.0, kStandardGravity);
  sensor_msgs::Imu message = ros_border::to_message(sample, kImuFrame);
  fill_diagonal(message.orientation_covariance, kSigma);
  // These poses have no gyro, which sensor_msgs/Imu marks by -1.
  message.angular_velocity_covariance[0] = -1.0;
  return message;
}

std::optional<Trajectory> enu_poses(const Options& options, std::size_t scans) {
  if (options.poses_enu.empty()) return std::nullopt;
  Trajectory poses = read_trajectory(options.poses_enu);
  if (poses.poses.size() != scans) {
    throw InputError(options.poses_enu + " has " + std::to_string(poses.poses.size()) +
                     " poses for " + std::to_string(scans) + " scans; it needs one for each");
  }
  return poses;
}

/// Writes data of a raw recording as messages, in their order.
class RawWriter {
 public:
  RawWriter(rosbag::Bag& bag, const pipeline::FolderInput& input) : bag_(bag) {
    tf2_msgs::TFMessage frames;
    for (const auto& [name, T_base] : input.frames()) {
      if (name != kBaseFrame) {
        frames.transforms.push_back(transform_message(T_base, name, input.begin()));
      }
    }
    bag_.write("/tf_static", ros_border::to_ros(input.begin()), frames);
  }

  void operator()(const pipeline::RecordedScan& scan) {
    const preprocessing::RawScan raw = scan.decode({});
    write(kCloudTopic, scan.stamp, ros_border::to_message(raw.cloud, scan.stamp, raw.frame_id));
  }
  void operator()(const pipeline::FramedSample<ImuSample>& imu) {
    write(kImuTopic, imu.sample.stamp, ros_border::to_message(imu.sample, imu.frame_id));
  }
  void operator()(const pipeline::FramedSample<VelocitySample>& velocity) {
    write(kVelocityTopic, velocity.sample.stamp,
          ros_border::to_message(velocity.sample, velocity.frame_id));
  }
  void operator()(const pipeline::FramedSample<GnssFix>& fix) {
    write(kFixTopic, fix.sample.stamp, ros_border::to_message(fix.sample, fix.frame_id));
  }

 private:
  template <typename Message>
  void write(const char* topic, Stamp stamp, const Message& message) {
    bag_.write(topic, ros_border::to_ros(stamp), message);
  }

  rosbag::Bag& bag_;
};

void convert_raw(const Options& options) {
  pipeline::FolderOptions folder;
  folder.sensor_height = options.sensor_height;
  pipeline::FolderInput input(options.folder, folder);
  std::cout << input.description() << "\n";
  write_whole_bag(options.bag, [&](rosbag::Bag& bag) {
    RawWriter write(bag, input);
    ProgressBar progress("writing messages", input.size());
    for (std::size_t done = 0; auto datum = input.next();) {
      std::visit(write, *datum);
      progress.show(++done);
    }
  });
}

void fill_bag(const Options& options, const pipeline::KittiFolder& folder,
              const std::optional<Trajectory>& poses, rosbag::Bag& bag) {
  const Stamp start = from_seconds(options.start);
  bag.write("/tf_static", ros_border::to_ros(start + folder.stamp(0)),
            extrinsics(options, start + folder.stamp(0)));
  ProgressBar progress("writing scans", folder.size());
  for (std::size_t i = 0; i < folder.size(); ++i) {
    const Stamp stamp = start + folder.stamp(i);
    const ros::Time time = ros_border::to_ros(stamp);
    if (poses) {
      const Pose& T_enu_lidar = poses->poses[i].pose;
      bag.write(kFixTopic, time, fix_at(T_enu_lidar.translation, options, stamp));
      bag.write(kImuTopic, time, attitude_at(T_enu_lidar, stamp));
    }
    bag.write(kCloudTopic, time, ros_border::to_message(folder.scan(i).cloud, stamp, kLidarFrame));
    progress.show(i + 1);
  }
}

void convert_odometry(const Options& options) {
  const pipeline::KittiFolder folder(options.folder);
  const auto poses = enu_poses(options, folder.size());
  write_whole_bag(options.bag, [&](rosbag::Bag& bag) { fill_bag(options, folder, poses, bag); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Writes a raw or odometry folder of KITTI as a bag for mapping.launch"};
  Options options;
  app.add_option("folder", options.folder,
                 "folder with velodyne_points/ and oxts/, or with velodyne/ and times.txt")
      ->required();
  app.add_option("bag", options.bag, "bag to write")->required();
  app.add_option("--poses-enu", options.poses_enu,
                 "poses of the LiDAR in East-North-Up, 12 numbers a line: written as GNSS and IMU");
  app.add_option("--datum", options.datum,
                 "latitude and longitude (deg), altitude (m) of the poses")
      ->expected(3)
      ->capture_default_str();
  app.add_option("--gnss-sigma", options.gnss_sigma, "standard deviation that the fixes claim, m")
      ->check(tools::above_zero())
      ->capture_default_str();
  app.add_option("--sensor-height", options.sensor_height, "height of the LiDAR over base_link, m")
      ->capture_default_str();
  app.add_option("--start", options.start, "time of the first scan, s since 1970")
      ->capture_default_str();
  bool force = false;
  app.add_flag("--force", force, "overwrite a bag that exists");
  return tools::run_command(app, argc, argv, [&] {
    tools::check_overwriting({options.bag}, force);
    const bool is_raw = std::filesystem::is_directory(options.folder + "/velodyne_points");
    is_raw ? convert_raw(options) : convert_odometry(options);
  });
}
