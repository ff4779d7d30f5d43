// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/session/map_datum.hpp"

#include "file_content.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::content_of;
using test::TemporaryFolder;

constexpr KeyFrameIndex kKeyFrames = 12;
constexpr Stamp kStart = 1'700'000'000'000'000'005;

Pose true_pose(KeyFrameIndex index) {
  const double angle = 2.0 * M_PI * index / kKeyFrames;
  return {exp_so3({0.01, 0.0, angle}),
          {20.0 * std::sin(angle), 20.0 - 20.0 * std::cos(angle), 0.5}};
}

Stamp stamp_of(KeyFrameIndex index) { return kStart + Stamp{index} * 200'000'000; }

/// Two segments, a loop between them, a floor, an IMU sample and a position.
Session example_session(const fs::path& folder) {
  Session session = Session::create_in(folder);
  session.set_datum({49.0, 8.4, 110.0});
  session.set_sensor_origin({0.5, 0.0, 1.8});
  for (KeyFrameIndex index = 0; index < kKeyFrames; ++index) {
    KeyFrame key_frame;
    key_frame.index = 10 + index;  // need not begin with 0
    key_frame.segment = index < 7 ? 0 : 1;
    key_frame.stamp = stamp_of(index);
    key_frame.T_odom_base = true_pose(index);
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    auto cloud = std::make_shared<PointCloud>();
    cloud->points.assign(3, {1.0F, 2.0F, static_cast<float>(index), 4.0F});
    key_frame.cloud = cloud;
    session.add_key_frame(key_frame);
  }
  Loop loop;
  loop.from = 12;
  loop.to = 20;
  loop.stamp = stamp_of(10);
  loop.T_from_to = true_pose(2).inverse() * true_pose(10);
  loop.covariance = diagonal_covariance(0.05, 0.005);
  session.add_loop(loop);
  Floor floor;
  floor.stamp = stamp_of(3);
  floor.found = true;
  floor.offset = 1.73;
  session.add_floor(floor);
  ImuSample sample;
  sample.stamp = stamp_of(4);
  sample.linear_acceleration = {0.1, 0.2, 9.8};
  sample.orientation = exp_so3({0.0, 0.0, 0.3});
  session.add_imu(sample);
  GnssPosition position;
  position.stamp = stamp_of(5);
  position.p_enu_antenna = {100.0, 200.0, 3.0};
  position.p_base_antenna = {-0.8, 0.5, 1.6};
  session.add_gnss(position);
  return session;
}

pose_graph::PoseGraph graph_of(const Session& session) {
  back_end::BackEnd back_end({});
  replay(session, back_end);
  back_end.apply(*back_end::solve(*back_end.problem(true)));
  return back_end.graph();
}

void dump(const Session& session, const fs::path& directory, bool in_enu = false) {
  write_hdl_dump(session, graph_of(session), in_enu, directory);
}

TEST(HdlDump, WritesFilesOfInteractiveSlam) {
  const TemporaryFolder folder;
  const Session session = example_session(folder.path() / "session");
  const fs::path directory = folder.path() / "dump";
  dump(session, directory);
  EXPECT_EQ(content_of(directory / "special_nodes.csv"),
            "anchor_node 22\nanchor_edge -1\nfloor_node -1\n");
  const std::string graph = content_of(directory / "graph.g2o");
  EXPECT_NE(graph.find("VERTEX_SE3:QUAT 22 "), std::string::npos);
  EXPECT_NE(graph.find("EDGE_SE3:QUAT 22 10 "), std::string::npos);
  EXPECT_NE(graph.find("\nFIX 22\n"), std::string::npos);
  EXPECT_NE(graph.find("EDGE_SE3:QUAT 12 20 "), std::string::npos);
  EXPECT_FALSE(fs::exists(directory / "000012"));
  const std::string data = content_of(directory / "000003" / "data");
  EXPECT_EQ(data.substr(0, 27), "stamp 1700000000 600000005\n");
  for (const char* field : {"\nestimate\n", "\nodom\n", "\naccum_distance ",
                            "\nfloor_coeffs 0 0 1 1.73", "\nid 13\n"}) {
    EXPECT_NE(data.find(field), std::string::npos) << field << "\n" << data;
  }
  EXPECT_EQ(session::read_pcd(directory / "000003" / "cloud.pcd").points[0].z, 3.0F);
  EXPECT_NE(content_of(directory / "000005" / "data").find("\nutm_coord "), std::string::npos);
  EXPECT_NE(content_of(directory / "zero_utm").find(' '), std::string::npos);
  EXPECT_THROW(dump(session, directory), FileError) << "is there";
}

TEST(HdlDump, FolderMayEndWithASlash) {
  const TemporaryFolder folder;
  const Session session = example_session(folder.path() / "session");
  dump(session, folder.path() / "dump" / "");
  EXPECT_TRUE(fs::is_regular_file(folder.path() / "dump" / "graph.g2o"));
}

/// hdl_graph_slam writes "nan" for the height of a GeoPoint without altitude.
TEST(HdlDump, ReadsPositionsWithoutHeight) {
  const TemporaryFolder folder;
  const Session before = example_session(folder.path() / "session");
  dump(before, folder.path() / "dump");
  const fs::path file = folder.path() / "dump" / "000005" / "data";
  std::string data = content_of(file);
  const std::size_t at = data.find("utm_coord ") + 10;
  const std::size_t height = data.find_last_of(' ', data.find('\n', at)) + 1;
  data.replace(height, data.find('\n', at) - height, "nan");
  std::ofstream(file) << data;
  Session after = Session::create_in(folder.path() / "back");
  read_hdl_dump(folder.path() / "dump", after);
  ASSERT_EQ(after.gnss().size(), before.gnss().size());
  const GnssPosition position = after.gnss().at(0);
  EXPECT_TRUE(position.p_enu_antenna.allFinite());
  EXPECT_FALSE(has_height(position.covariance));
}

/// interactive_slam reads numbers in utm_coord, and for ever if one is "nan".
TEST(HdlDump, KeepsPositionsWithoutHeightInAFieldThatOthersSkip) {
  const TemporaryFolder folder;
  Session before = example_session(folder.path() / "session");
  GnssPosition position;
  position.stamp = stamp_of(6);
  position.p_enu_antenna = {104.0, 203.0, 0.0};
  position.covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
  before.add_gnss(position);
  dump(before, folder.path() / "dump");
  const std::string data = content_of(folder.path() / "dump" / "000006" / "data");
  EXPECT_EQ(data.find("utm_coord"), std::string::npos);
  EXPECT_EQ(data.find("nan"), std::string::npos);
  Session after = Session::create_in(folder.path() / "back");
  read_hdl_dump(folder.path() / "dump", after);
  ASSERT_EQ(after.gnss().size(), 2U);
  const GnssPosition read = after.gnss().at(1);
  EXPECT_TRUE(test::near(read.p_enu_antenna.head<2>(), position.p_enu_antenna.head<2>(), 1e-3));
  EXPECT_FALSE(has_height(read.covariance));
}

/// Where on Earth the map of a dump lies after its import.
std::optional<GeodeticDatum> datum_of_map(bool in_enu, const char* left_out = nullptr) {
  const TemporaryFolder folder;
  dump(example_session(folder.path() / "session"), folder.path() / "dump", in_enu);
  if (left_out) fs::remove(folder.path() / "dump" / left_out);
  Session after = Session::create_in(folder.path() / "back");
  read_hdl_dump(folder.path() / "dump", after);
  return session::map_datum(after);
}

TEST(HdlDump, KnowsWhetherItsPosesLieInEastNorthUp) {
  EXPECT_TRUE(datum_of_map(true));
  EXPECT_FALSE(datum_of_map(false)) << "of a drive without use_gnss, say";
  EXPECT_FALSE(datum_of_map(true, "poses_in_enu")) << "nobody says so";
}

// Axes of a map that is not aligned say nothing of where the antenna is to the east and north.
TEST(HdlDump, SubtractsTheHeightOfTheAntennaAloneWithoutAHeading) {
  const TemporaryFolder folder;
  const Session before = example_session(folder.path() / "session");
  ASSERT_FALSE(before.gnss()[0].R_enu_base);
  write_hdl_dump(before, graph_of(before), false, folder.path() / "dump");
  Session after = Session::create_in(folder.path() / "back");
  read_hdl_dump(folder.path() / "dump", after);
  const GnssPosition position = before.gnss()[0];
  const Eigen::Vector3d lever(0.0, 0.0, position.p_base_antenna.z());
  EXPECT_TRUE(test::near(after.gnss()[0].p_enu_antenna, position.p_enu_antenna - lever, 1e-6));
}

// Writing and reading keeps everything that the format supports.
TEST(HdlDump, RoundTripKeepsContents) {
  const TemporaryFolder folder;
  const Session before = example_session(folder.path() / "session");
  const pose_graph::PoseGraph graph = graph_of(before);
  write_hdl_dump(before, graph, true, folder.path() / "dump");
  Session after = Session::create_in(folder.path() / "back");
  const HdlImport imported = read_hdl_dump(folder.path() / "dump", after);
  EXPECT_EQ(imported.key_frames, kKeyFrames);
  EXPECT_EQ(imported.loops, 1U);
  EXPECT_EQ(imported.segments, 2U);
  const auto a = before.key_frames();
  const auto b = after.key_frames();
  for (std::size_t i = 0; i < kKeyFrames; ++i) {
    EXPECT_EQ(b[i].stamp, a[i].stamp);
    EXPECT_EQ(b[i].segment, a[i].segment);
    EXPECT_TRUE(test::near(b[i].T_odom_base, a[i].T_odom_base, 1e-9));
    EXPECT_TRUE(test::near(after.poses().poses[i].T_map_base, graph.nodes[i].pose, 1e-9));
    EXPECT_EQ(after.clouds().cloud(b[i].index)->points[0].z, static_cast<float>(i));
  }
  const Loop loop = after.loops().at(0);
  EXPECT_EQ(loop.from, 2U);
  EXPECT_EQ(loop.to, 10U);
  EXPECT_TRUE(test::near(loop.T_from_to, before.loops()[0].T_from_to, 1e-9));
  EXPECT_TRUE(is_valid_covariance(loop.covariance));
  EXPECT_NEAR(std::sqrt(loop.covariance(0, 0)), 0.05, 0.01);
  EXPECT_NEAR(std::sqrt(loop.covariance(5, 5)), 0.005, 0.002);
  ASSERT_EQ(after.floors().size(), 1U);
  EXPECT_EQ(after.floors()[0].offset, 1.73);
  ASSERT_EQ(after.imu().size(), 1U);
  EXPECT_LT(after.imu()[0].orientation->angularDistance(*before.imu()[0].orientation), 1e-9);
  ASSERT_EQ(after.gnss().size(), 1U);
  const Eigen::Vector3d p_base = before.gnss()[0].p_enu_base(graph.nodes[5].pose.rotation);
  EXPECT_TRUE(test::near(after.gnss()[0].p_enu_antenna, p_base, 1e-6)) << "of base_link";
  EXPECT_TRUE(after.gnss()[0].p_base_antenna.isZero());
  EXPECT_EQ(after.poses_in_enu(), true);
  EXPECT_EQ(after.datum(), before.datum());
  EXPECT_EQ(after.sensor_origin(), before.sensor_origin());
}

/// As hdl_graph_slam itself writes it: edges from the newer key frame, six digits, planes.
TEST(HdlDump, ReadsReversedEdgesAndSkipsPlanes) {
  const TemporaryFolder folder;
  const fs::path dump = folder.path();
  std::ofstream(dump / "graph.g2o")
      << "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nFIX 0\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n"
         "VERTEX_PLANE 2 0 0 1 0 0 0 0\nVERTEX_SE3:QUAT 3 2 0 0 0 0 0.707107 0.707107\n"
         "EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"
         "EDGE_SE3:QUAT 3 1 0 2 0 0 0 -0.707107 0.707107 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 100 0 0 "
         "100 0 100\n"
         "EDGE_SE3_PLANE 3 2 0 0 1 0 1 0 0 1 0 1\n";
  for (int i = 0; i < 2; ++i) {
    const fs::path frame = dump / ("00000" + std::to_string(i));
    fs::create_directory(frame);
    std::ofstream(frame / "data")
        << "stamp 5 " << 7 + i << "\nestimate\n1 0 0 " << 2 * i
        << "\n0 1 0 0\n0 0 1 0\n0 0 0 1\nodom\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
           "0 0 0 1\naccum_distance 0\nid "
        << (i == 0 ? 1 : 3) << "\n";
    PointCloud cloud;
    cloud.points = {{1.0F, 2.0F, 3.0F, 4.0F}};
    session::write_pcd(frame / "cloud.pcd", cloud);
  }
  Session session = Session::create_in(folder.path() / "session");
  const HdlImport imported = read_hdl_dump(dump, session);
  EXPECT_EQ(imported.key_frames, 2U);
  EXPECT_EQ(imported.loops, 0U);
  EXPECT_EQ(imported.segments, 1U);
  const KeyFrame second = session.key_frames()[1];
  EXPECT_TRUE(test::near(second.T_odom_base.translation, Eigen::Vector3d(2.0, 0.0, 0.0), 1e-5));
  EXPECT_NEAR(yaw_of(second.T_odom_base.rotation), M_PI / 2.0, 1e-5);
  EXPECT_NEAR(second.motion_covariance(3, 3), 0.04, 1e-6);
  EXPECT_EQ(session.poses().poses[1].T_map_base.translation.x(), 2.0);
}

TEST(HdlDump, ReportsMissingFiles) {
  const TemporaryFolder folder;
  Session session = Session::create_in(folder.path() / "session");
  EXPECT_THROW(read_hdl_dump(folder.path() / "none", session), FileError);
  fs::create_directories(folder.path() / "dump" / "000000");
  std::ofstream(folder.path() / "dump" / "000000" / "data") << "stamp 1 2\nestimate\n1 0 x";
  EXPECT_THROW(read_hdl_dump(folder.path() / "dump", session), FileError);
}

TEST(HdlDump, RejectsInvalidDatum) {
  const TemporaryFolder folder;
  const Session before = example_session(folder.path() / "session");
  for (const char* text : {"", "49 8", "nan 8 1", "91 8 110", "north 8 110"}) {
    fs::remove_all(folder.path() / "dump");
    dump(before, folder.path() / "dump");
    std::ofstream(folder.path() / "dump" / "datum") << text;
    fs::remove_all(folder.path() / "back");
    Session after = Session::create_in(folder.path() / "back");
    EXPECT_THROW(read_hdl_dump(folder.path() / "dump", after), FileError) << text;
  }
}

}  // namespace
}  // namespace lidar_mapping::pipeline
