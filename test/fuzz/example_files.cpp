// SPDX-License-Identifier: BSD-3-Clause
#include "example_files.hpp"

#include <cmath>
#include <fstream>
#include <limits>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"
#include "lidar_mapping/session/session.hpp"

#include "example_points.hpp"
#include "localization_record.hpp"

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
    cloud->points = example_points();
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
                           circle(false), false, folder);
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
    write_binary(folder / "velodyne_points" / "data" / (name + ".bin"), example_points());
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
    for (const Point& p : example_points()) {
      scan << p.x << ' ' << p.y << ' ' << p.z << ' ' << p.intensity << '\n';
    }
  }
}

void write_scan_folder(const fs::path& folder) {
  write_binary(folder / "0.bin", example_points());
  write_pcd(folder / "1.pcd", "binary", true);
  std::ofstream(folder / "times.txt") << "0.0\n0.1\n";
}

void write_kitti_odometry(const fs::path& folder) {
  fs::create_directories(folder / "velodyne");
  fs::create_directories(folder / "point_times");
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < 3; ++i) {
    const std::string name = "00000" + std::to_string(i);
    write_binary(folder / "velodyne" / (name + ".bin"), example_points());
    write_binary(folder / "point_times" / (name + ".f32"), std::vector<float>(60, 0.01F));
    times << 0.1 * i << '\n';
  }
}

void write_pcd(const fs::path& path, const std::string& data, bool times) {
  pcl::PCLPointCloud2 raw;
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (const Point& point : example_points()) {
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
  stretch.key_frames = pipeline::KeyFrameRange{1, 4};
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
