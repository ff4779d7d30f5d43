// SPDX-License-Identifier: BSD-3-Clause
#include "example_files.hpp"

#include <cmath>
#include <fstream>
#include <limits>

#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"
#include "lidar_mapping/ros/nmea_sentence.hpp"
#include "lidar_mapping/session/session.hpp"

#include "../ros/cloud_builder.hpp"
#include "cloud_forms.hpp"
#include "hesai_messages.hpp"
#include "localization_record.hpp"
#include "mcap_writer.hpp"
#include "ouster_messages.hpp"
#include "ros2_writer.hpp"

namespace lidar_mapping::test {

namespace {

namespace fs = std::filesystem;

constexpr Stamp kStart = 1'700'000'000'000'000'000;
constexpr KeyFrameIndex kKeyFrames = 6;

/// On a circle.
Pose place(int index) {
  const double angle = 0.3 * index;
  return {exp_so3({0.0, 0.0, angle}),
          {20.0 * std::sin(angle), 20.0 - 20.0 * std::cos(angle), 0.1 * index}};
}

Stamp stamp_of(int index) { return kStart + Stamp{index} * 200'000'000; }

std::vector<Point> points() {
  std::vector<Point> points;
  for (int i = 0; i < 60; ++i) {
    const auto f = static_cast<float>(i);
    points.push_back({10.0F * std::cos(f), 10.0F * std::sin(f), 0.1F * f, f});
  }
  return points;
}

sensor_msgs::PointCloud2 cloud(const ros::Time& stamp) {
  constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;
  sensor_msgs::PointCloud2 message =
      xyz_cloud({{"intensity", kFloat, 12}, {"time", kFloat, 16}}, 20, 60, stamp);
  for (std::size_t i = 0; i < message.width; ++i)
    put(message, i, 16, 0.001F * static_cast<float>(i));
  return message;
}

pose_graph::PoseGraph circle(bool planar) {
  pose_graph::PoseGraph graph;
  graph.planar = planar;
  for (int i = 0; i < static_cast<int>(kKeyFrames); ++i) {
    Pose pose = place(i);
    if (planar) pose.translation.z() = 0.0;
    graph.nodes.push_back({i, pose});
  }
  for (std::size_t i = 0; i < kKeyFrames; ++i) {
    const std::size_t next = (i + 1) % kKeyFrames;
    pose_graph::PoseEdge edge;
    edge.from = graph.nodes[i].id;
    edge.to = graph.nodes[next].id;
    edge.T_from_to = graph.nodes[i].pose.inverse() * graph.nodes[next].pose;
    edge.information = 100.0 * Matrix6d::Identity();
    graph.edges.push_back(edge);
  }
  return graph;
}

template <typename T>
void write_binary(const fs::path& path, const std::vector<T>& values) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(T)));
}

}  // namespace

void write_bag(const fs::path& path, rosbag::compression::CompressionType compression) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(4000);
  tf2_msgs::TFMessage frames;
  for (const char* frame : {"lidar", "imu", "gps"}) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = ros::Time(100);
    transform.header.frame_id = "base_link";
    transform.child_frame_id = frame;
    transform.transform.rotation.w = 1.0;
    frames.transforms.push_back(transform);
  }
  bag.write("/tf_static", ros::Time(100), frames);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    sensor_msgs::Imu imu;
    imu.header.stamp = now;
    imu.header.frame_id = "imu";
    imu.linear_acceleration.z = 9.81;
    imu.orientation.w = 1.0;
    bag.write("/imu", now, imu);
    geometry_msgs::TwistStamped velocity;
    velocity.header = imu.header;
    velocity.twist.linear.x = 5.0;
    bag.write("/velocity", now, velocity);
    sensor_msgs::NavSatFix fix;
    fix.header.stamp = now;
    fix.header.frame_id = "gps";
    fix.latitude = 49.0 + 1e-6 * i;
    fix.longitude = 8.0;
    bag.write("/fix", now, fix);
    bag.write("/points", now, cloud(now));
  }
  bag.close();
}

void write_bag_of_other_types(const fs::path& path) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::LZ4);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    ros_border::NmeaSentence sentence;
    sentence.header.stamp = now;
    sentence.header.frame_id = "gps";
    sentence.sentence = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47";
    bag.write("/sentences", now, sentence);
    geometry_msgs::TwistWithCovarianceStamped velocity;
    velocity.header = sentence.header;
    velocity.twist.twist.linear.x = 5.0;
    bag.write("/velocity", now, velocity);
    tf2_msgs::TFMessage frames;
    frames.transforms.resize(1);
    frames.transforms[0].header.stamp = now;
    frames.transforms[0].header.frame_id = "odom";
    frames.transforms[0].child_frame_id = "base_link";
    frames.transforms[0].transform.rotation.w = 1.0;
    bag.write("/tf", now, frames);
    bag.write("/points", now, cloud(now));
  }
  bag.close();
}

namespace {

VelodyneScanMessage velodyne_scan(const ros::Time& now) {
  VelodyneScanMessage scan;
  scan.header.stamp = now;
  scan.header.frame_id = "lidar";
  scan.packets.resize(3);
  for (std::size_t p = 0; p < scan.packets.size(); ++p) {
    const auto microseconds = static_cast<std::uint32_t>(1327 * p);
    scan.packets[p].stamp = now + ros::Duration(1e-6 * microseconds);
    for (std::size_t b = 0; b < 12; ++b) {
      put_block(scan.packets[p].data, b, static_cast<std::uint16_t>(40 * (12 * p + b)),
                [](std::size_t channel) {
                  return VelodyneReturn{static_cast<std::uint16_t>(2000 + channel), 9};
                });
    }
    put_end(scan.packets[p].data, microseconds, kStrongest, kIsVlp16);
  }
  return scan;
}

std::string hesai_channels() {
  std::string text = "Channel,Elevation,Azimuth\n";
  for (int i = 1; i <= 16; ++i) {
    text += std::to_string(i) + "," + std::to_string(17 - 2 * i) + ",-0.25\n";
  }
  return text;
}

/// Packets in dual return mode, and the calibration beside them.
template <PandarDriver driver>
PandarScanMessage<driver> hesai_scan(const ros::Time& now) {
  PandarScanMessage<driver> scan;
  if (driver == PandarDriver::kPandarMsgs) scan.header.stamp = now;
  scan.header.frame_id = "lidar";
  for (std::size_t p = 0; p < 3; ++p) {
    std::vector<HesaiBlock> blocks;
    for (std::size_t b = 0; b < 8; ++b) {
      blocks.push_back({static_cast<std::uint16_t>(18 * (4 * p + b / 2)), [b](std::size_t laser) {
                          return HesaiReturn{static_cast<std::uint16_t>(2000 + b * laser), 9};
                        }});
    }
    const auto microseconds = static_cast<std::uint32_t>(200 * p);
    scan.packets.emplace_back(now + ros::Duration(1e-6 * microseconds),
                              HesaiPacketWriter(kPandarXt16).write(blocks, microseconds));
  }
  scan.packets.emplace_back(now, hesai_calibration_packet(hesai_channels()));
  return scan;
}

/// Some packets of a turn and one of the IMU, and before the first ones the metadata.
void write_ouster_turn(rosbag::Bag& bag, const ros::Time& now, std::uint32_t turn) {
  OusterSensor sensor;
  sensor.columns = 32;
  sensor.altitudes_deg = sensor.azimuths_deg = {2.0, 0.5, -1.0};
  std_msgs::String metadata;
  metadata.data = sensor.metadata();
  if (turn == 0) bag.write("/os/metadata", now, metadata);
  const std::uint64_t step = 3'000'000;  // ns
  for (std::size_t first = 0; first < sensor.columns; first += sensor.columns_per_packet) {
    const std::uint64_t begin = now.toNSec() + first * step;
    const OusterPacketMessage packet{
        ouster_packet(sensor, static_cast<std::uint16_t>(turn), first, begin, step,
                      [](std::size_t column, std::size_t pixel) {
                        return OusterReturn{static_cast<std::uint32_t>(3000 + column + pixel), 9};
                      })};
    bag.write("/os/lidar_packets", ros::Time().fromNSec(begin + 8 * step), packet);
  }
  const OusterPacketMessage imu{ouster_imu_packet(now.toNSec(), {0.0, 0.0, 1.0}, {0.0, 0.0, 5.0})};
  bag.write("/os/imu_packets", now, imu);
}

sensor_msgs::PointCloud2 timed_cloud(const ros::Time& now) {
  std_msgs::Header header;
  header.stamp = now;
  header.frame_id = "lidar";
  std::vector<TimedPoint> timed;
  for (const Point& p : points())
    timed.push_back({p.x, p.y, p.z, p.intensity, 0.001F * p.intensity});
  return plain_cloud(header, timed);
}

}  // namespace

void write_bag_of_driver(const fs::path& path, const std::string& driver) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  for (std::uint32_t i = 0; i < 10; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    const sensor_msgs::PointCloud2 cloud = timed_cloud(now);
    if (driver == "livox") bag.write("/points", now, as_livox<LivoxDriver::kTwo>(cloud));
    if (driver == "velodyne") bag.write("/points", now, velodyne_scan(now));
    if (driver == "hesai") bag.write("/points", now, hesai_scan<PandarDriver::kHesaiLidar>(now));
    if (driver == "pandar") bag.write("/points", now, hesai_scan<PandarDriver::kPandarMsgs>(now));
    if (driver == "ouster") write_ouster_turn(bag, now, i);
    if (driver == "point_cloud1") bag.write("/points", now, as_point_cloud1(cloud));
    if (driver == "split_times") bag.write("/points", now, with_split_times(cloud));
  }
  bag.close();
}

namespace {

template <typename Writer>
void fill_ros2_recording(Writer& out) {
  for (std::uint32_t i = 0; i < 10; ++i) {
    const ros::Time now(100 + i / 10, i % 10 * 100'000'000);
    tf2_msgs::TFMessage frames;
    frames.transforms.resize(1);
    frames.transforms[0].header.stamp = now;
    frames.transforms[0].header.frame_id = "base_link";
    frames.transforms[0].child_frame_id = "lidar";
    frames.transforms[0].transform.rotation.w = 1.0;
    out.add("/tf", now, frames);
    sensor_msgs::Imu imu;
    imu.header.stamp = now;
    imu.header.frame_id = "lidar";
    imu.linear_acceleration.z = 9.81;
    imu.orientation.w = 1.0;
    out.add("/imu", now, imu);
    out.add("/points", now, timed_cloud(now));
  }
}

}  // namespace

void write_ros2_recording(const fs::path& path) {
  Ros2Writer out(path);
  fill_ros2_recording(out);
}

void write_mcap_recording(const fs::path& path, const std::string& compression) {
  McapOptions options;
  options.compression = compression;
  // Damage is to reach what is read behind the checksums, too.
  options.has_checksums = compression == "lz4";
  options.has_summary = compression != "zstd";
  McapWriter out(path, options);
  fill_ros2_recording(out);
}

void write_velodyne_calibration(const fs::path& path) {
  std::ofstream file(path);
  file << "num_lasers: 16\ndistance_resolution: 0.002\nlasers:\n";
  for (int id = 0; id < 16; ++id) {
    file << "- {laser_id: " << id << ", rot_correction: 0.01, vert_correction: " << 0.03 * id - 0.2
         << ", dist_correction: 0.1, dist_correction_x: 0.12, dist_correction_y: 0.11, "
            "two_pt_correction_available: true, vert_offset_correction: 0.02, "
            "horiz_offset_correction: 0.026, focal_distance: 12, focal_slope: 1.4}\n";
  }
}

void write_hesai_calibration(const fs::path& path) { std::ofstream(path) << hesai_channels(); }

void write_session(const fs::path& folder) {
  session::Session session = session::Session::create_in(folder);
  session.set_datum({49.0, 8.4, 110.0});
  session.set_sensor_origin({0.0, 0.0, 1.7});
  session.set_configuration("map", "resolution: 0.2\n");
  KeyFramePoses poses;
  poses.revision = 1;
  for (KeyFrameIndex i = 0; i < kKeyFrames; ++i) {
    KeyFrame key_frame;
    key_frame.index = i;
    key_frame.stamp = stamp_of(static_cast<int>(i));
    key_frame.T_odom_base = place(static_cast<int>(i));
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    auto cloud = std::make_shared<PointCloud>();
    cloud->points = points();
    key_frame.cloud = cloud;
    session.add_key_frame(key_frame);
    session.add_odometry(key_frame.stamp, key_frame.T_odom_base);
    poses.poses.push_back({i, key_frame.stamp, key_frame.T_odom_base});
    GnssPosition position;
    position.stamp = key_frame.stamp;
    position.p_enu_antenna = key_frame.T_odom_base.translation;
    session.add_gnss(position);
  }
  Loop loop;
  loop.from = 0;
  loop.to = kKeyFrames - 1;
  loop.stamp = stamp_of(kKeyFrames - 1);
  loop.T_from_to = place(0).inverse() * place(kKeyFrames - 1);
  loop.covariance = diagonal_covariance(0.05, 0.005);
  session.add_loop(loop);
  LoopVerdict verdict;
  verdict.from = loop.from;
  verdict.to = loop.to;
  verdict.reason = "it fits";
  session.add_verdict(verdict);
  Floor floor;
  floor.stamp = stamp_of(1);
  floor.found = true;
  session.add_floor(floor);
  ImuSample imu;
  imu.stamp = stamp_of(2);
  imu.linear_acceleration = {0.1, 0.2, 9.8};
  imu.orientation = Eigen::Quaterniond::Identity();
  session.add_imu(imu);
  session::RevisionRecord record;
  record.revision = 1;
  record.key_frames = kKeyFrames;
  session.set_poses(poses, record);
}

void write_localized_drive(const fs::path& folder, const fs::path& session) {
  const auto map = session::Session::open(session, session::Session::Access::kRead).poses();
  const char* states[] = {"searching", "following", "following", "beside_map", "lost", "following"};
  fs::create_directories(folder / "trajectory");
  std::ofstream table(folder / "localization.csv");
  table << "stamp,state,x,y,z,qx,qy,qz,qw,agreement,coverage,path,segment,reason\n";
  Trajectory odometry;
  for (int i = 0; i < static_cast<int>(kKeyFrames); ++i) {
    const std::string state = states[i];
    const Pose pose = place(i);
    odometry.poses.push_back({stamp_of(i) + 86'400 * kNanosecondsPerSecond, pose});
    table << seconds_text(odometry.poses.back().stamp) << ',' << state << ',';
    if (state == "searching" || state == "lost") {
      table << ",,,,,,,";
    } else {
      const Eigen::Vector3d& p = pose.translation;
      const Eigen::Quaterniond& q = pose.rotation;
      table << p.x() << ',' << p.y() << ',' << p.z() << ',' << q.x() << ',' << q.y() << ',' << q.z()
            << ',' << q.w() << ',';
    }
    table << "0.7,0.9," << 6 * i << ",0,\"the map shows 70 %, or nearly\"\n";
  }
  table.close();
  std::ofstream(folder / "trajectory" / "laser_odom_scans.tum") << to_tum(odometry);
  report::write_localization_record(folder, {{"tuesday.bag"}, report::identity_of(map, session)});
}

void write_hdl_dump(const fs::path& folder) {
  const fs::path session = folder.parent_path() / "session_of_dump";
  write_session(session);
  pipeline::write_hdl_dump(session::Session::open(session, session::Session::Access::kRead),
                           circle(false), folder);
  fs::remove_all(session);
}

void write_kitti_raw(const fs::path& folder) {
  fs::create_directories(folder / "velodyne_points" / "data");
  fs::create_directories(folder / "oxts" / "data");
  std::ofstream scans(folder / "velodyne_points" / "timestamps.txt");
  std::ofstream oxts(folder / "oxts" / "timestamps.txt");
  for (int i = 0; i < 3; ++i) {
    const std::string date = "2011-09-26 13:02:2" + std::to_string(i) + ".967790592\n";
    const std::string name = "000000000" + std::to_string(i);
    scans << date;
    oxts << date;
    write_binary(folder / "velodyne_points" / "data" / (name + ".bin"), points());
    std::ofstream data(folder / "oxts" / "data" / (name + ".txt"));
    data << "49.015 8.434 116.4 0.03 0.01 -0.3";
    for (int column = 6; column < 30; ++column) data << ' ' << (column == 26 ? 8.0 : 0.5);
    data << '\n';
  }
  std::ofstream(folder / "calib_imu_to_velo.txt")
      << "calib_time: 25-May-2012 16:47:16\nR: 1 0 0 0 1 0 0 0 1\nT: -0.81 0.32 -0.8\n";
}

void write_kitti_raw_text(const fs::path& folder) {
  const fs::path velodyne = folder / "velodyne_points";
  fs::create_directories(velodyne / "data");
  std::ofstream dates(velodyne / "timestamps.txt");
  for (int i = 0; i < 2; ++i) {
    dates << "2011-09-26 13:02:2" << i << ".967790592\n";
    std::ofstream scan(velodyne / "data" / ("000000000" + std::to_string(i) + ".txt"));
    for (const Point& p : points()) {
      scan << p.x << ' ' << p.y << ' ' << p.z << ' ' << p.intensity << '\n';
    }
  }
}

void write_scan_folder(const fs::path& folder) {
  write_binary(folder / "0.bin", points());
  write_pcd(folder / "1.pcd", "binary", true);
  std::ofstream(folder / "times.txt") << "0.0\n0.1\n";
}

void write_kitti_odometry(const fs::path& folder) {
  fs::create_directories(folder / "velodyne");
  fs::create_directories(folder / "point_times");
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < 3; ++i) {
    const std::string name = "00000" + std::to_string(i);
    write_binary(folder / "velodyne" / (name + ".bin"), points());
    write_binary(folder / "point_times" / (name + ".f32"), std::vector<float>(60, 0.01F));
    times << 0.1 * i << '\n';
  }
}

void write_pcd(const fs::path& path, const std::string& data, bool times) {
  pcl::PCLPointCloud2 raw;
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (const Point& point : points()) {
    pcl::PointXYZI to;
    to.x = point.x;
    to.y = point.y;
    to.z = point.z;
    to.intensity = point.intensity;
    cloud.push_back(to);
  }
  pcl::toPCLPointCloud2(cloud, raw);
  if (times) raw.fields.back().name = "time";
  pcl::PCDWriter writer;
  const Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  const Eigen::Quaternionf turned = Eigen::Quaternionf::Identity();
  if (data == "ascii") {
    writer.writeASCII(path.string(), raw, origin, turned);
  } else if (data == "binary") {
    writer.writeBinary(path.string(), raw, origin, turned);
  } else {
    writer.writeBinaryCompressed(path.string(), raw, origin, turned);
  }
}

void write_g2o(const fs::path& path, bool planar) {
  pose_graph::write_g2o(circle(planar), path.string());
}

void write_binary_graph(const fs::path& path, bool planar) {
  pose_graph::write_binary_graph(circle(planar), path.string());
}

void write_trajectory(const fs::path& path, bool kitti) {
  Trajectory trajectory;
  for (int i = 0; i < 8; ++i) trajectory.poses.push_back({stamp_of(i), place(i)});
  std::ofstream(path) << (kitti ? to_kitti(trajectory) : to_tum(trajectory));
}

void write_doubtful_stretches(const fs::path& path) {
  pipeline::DriveDoubt doubt;
  doubt.begin = stamp_of(0);
  doubt.path_length = 120.0;
  pipeline::DoubtfulSection stretch;
  stretch.doubt = pipeline::Doubt::kDegenerate;
  stretch.begin = stamp_of(1);
  stretch.end = stamp_of(3);
  stretch.scans = 3;
  stretch.path_begin = 20.0;
  stretch.path_length = 3.5;
  stretch.position = {1.0, 2.0, 0.5};
  stretch.expected_error = 0.25;
  doubt.sections.push_back(stretch);
  stretch.doubt = pipeline::Doubt::kLost;
  stretch.expected_error = std::numeric_limits<double>::infinity();
  doubt.sections.push_back(stretch);
  pipeline::write_doubt(doubt, path);
}

void write_loop_list(const fs::path& path) {
  std::ofstream(path) << "# Loops of the session.\nauto 0 5  # accepted\naccept 1 4\nrefuse 2 5\n"
                         "add 0 4 1.5 2.5 0.1\nadd 0 3 1.5 2.5 0.1 0 0 90\n";
}

}  // namespace lidar_mapping::test
