// SPDX-License-Identifier: BSD-3-Clause
// Whole imports of a made-up street.
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/session_map.hpp"
#include "lidar_mapping/session/imported_map.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "made_map.hpp"
#include "map_import.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map_import {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::near;

/// A street of 30 m by 10 m between two walls.
test::MadeMap street() {
  test::MadeMap map;
  map.add_rectangle({-15.1, -5.1, 2.0}, {30.0, 0.0, 0.0}, {0.0, 10.0, 0.0});
  for (const double y : {-5.3, 5.1}) {
    map.add_rectangle({-15.1, y, 2.0}, {30.0, 0.0, 0.0}, {0.0, 0.0, 6.0});
  }
  return map;
}

/// Writes coordinates as double numbers.
void write_map(const fs::path& path, const test::MadeMap& map,
               const Eigen::Vector3d& shift = Eigen::Vector3d::Zero()) {
  const std::string count = std::to_string(map.points.size());
  std::ofstream file(path, std::ios::binary);
  file << "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH " << count
       << "\nHEIGHT 1\nPOINTS " << count << "\nDATA binary\n";
  for (const MapPoint& point : map.points) {
    const Eigen::Vector3d p = point.p_map + shift;
    file.write(reinterpret_cast<const char*>(p.data()), 3 * sizeof(double));
  }
}

class ImportedSession : public testing::Test {
 protected:
  ImportedSession() { options.map = folder.path() / "town.pcd"; }

  Session imported() {
    return session::create_filled(folder.path() / "session", [&](Session& session) {
      import_map(
          options, session, [&](const std::string& line) { said += line + "\n"; },
          [&](std::size_t done, std::size_t all) {
            EXPECT_LE(done, all);
            places = all;
          });
    });
  }
  std::string refusal() {
    return test::error_text<InputError>([&] { imported(); });
  }

  test::TemporaryFolder folder;
  ImportOptions options;
  std::string said;
  std::size_t places = 0;
};

TEST_F(ImportedSession, HasKeyFramesOnTheGround) {
  write_map(options.map, street());
  options.base_height = 0.5;
  const Session session = imported();
  const std::vector<KeyFrame> key_frames = session.key_frames();
  ASSERT_GE(key_frames.size(), 5U);
  EXPECT_EQ(key_frames.size(), places);
  const KeyFramePoses poses = session.poses();
  EXPECT_EQ(poses.revision, 1U);
  ASSERT_EQ(poses.poses.size(), key_frames.size());
  for (std::size_t i = 0; i < key_frames.size(); ++i) {
    const Pose& pose = poses.poses[i].T_map_base;
    EXPECT_TRUE(near(pose, key_frames[i].T_odom_base, 1e-9));
    EXPECT_NEAR(pose.translation.z(), 2.5, 0.01);
    EXPECT_LT(std::abs(pose.translation.y()), 4.0);
    EXPECT_EQ(key_frames[i].segment, 0U);
  }
  EXPECT_LT(key_frames[1].motion_covariance(0, 0), 0.3 * 0.3);
  EXPECT_TRUE(near(session.sensor_origin().value(), Eigen::Vector3d(0.0, 0.0, 1.3), 1e-9));
  EXPECT_TRUE(session::is_imported_map(session));
  EXPECT_FALSE(session.datum());
  EXPECT_TRUE(fs::exists(session.directory() / "trajectory/optimized.tum"));
  EXPECT_NE(said.find("ground: "), std::string::npos) << said;
}

TEST_F(ImportedSession, HasTheMapInItsClouds) {
  write_map(options.map, street());
  const Session session = imported();
  const KeyFramePose first = session.poses().poses.front();
  const PointCloudPtr cloud = session.clouds().cloud(first.index);
  ASSERT_NE(cloud, nullptr);
  std::size_t ground = 0;
  std::size_t walls = 0;
  for (const Point& point : cloud->points) {
    const Eigen::Vector3d p = first.T_map_base * point.position().cast<double>();
    const bool is_ground = std::abs(p.z() - 2.0) < 0.2;
    const bool is_wall = std::abs(p.y() + 5.3) < 0.2 || std::abs(p.y() - 5.1) < 0.2;
    EXPECT_TRUE(is_ground || is_wall) << p.transpose();
    (is_wall ? walls : ground) += 1;
  }
  EXPECT_GT(ground, 300U);
  EXPECT_GT(walls, 300U);
}

TEST_F(ImportedSession, IsAMapForLocalisation) {
  write_map(options.map, street());
  options.datum = GeodeticDatum{49.0, 8.0, 100.0};
  const fs::path made = imported().directory();
  pipeline::SessionMap map(made, {}, 1);
  EXPECT_EQ(map.index().places().size(), places);
  EXPECT_GT(map.index().gaussians(), 300U);
  EXPECT_EQ(map.datum(), options.datum);
}

TEST_F(ImportedSession, IsTheSameForAnyNumberOfThreads) {
  write_map(options.map, street());
  std::string bytes[2];
  for (const int i : {0, 1}) {
    options.threads = i == 0 ? 1 : 3;
    const Session session = imported();
    for (const KeyFrame& key_frame : session.key_frames()) {
      bytes[i] += test::content_of(session.clouds().file(key_frame.index));
    }
    bytes[i] += test::content_of(session.directory() / "trajectory/optimized.tum");
    fs::rename(session.directory(), folder.path() / std::to_string(i));
  }
  EXPECT_GT(bytes[0].size(), 10'000U);
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(ImportedSession, FollowsATrajectory) {
  write_map(options.map, street());
  options.trajectory = folder.path() / "drive.tum";
  std::ofstream file(options.trajectory);
  for (int i = 0; i <= 20; ++i) file << 100 + i << " " << i - 10 << " 1 2 0 0 0 1\n";
  file.close();
  const Session session = imported();
  const std::vector<KeyFrame> key_frames = session.key_frames();
  ASSERT_EQ(key_frames.size(), 5U);
  EXPECT_EQ(key_frames[1].stamp, from_seconds(105.0));
  EXPECT_TRUE(near(key_frames[1].T_odom_base.translation, Eigen::Vector3d(-5.0, 1.0, 2.0), 1e-9));
}

TEST_F(ImportedSession, OfAMapInUtmCountsFromARoundPlaceInIt) {
  write_map(options.map, street(), {456'700.0, 5'428'800.0, 0.0});
  const Session session = imported();
  for (const KeyFramePose& pose : session.poses().poses) {
    EXPECT_NEAR(pose.T_map_base.translation.x(), -300.0, 15.0);
    EXPECT_NEAR(pose.T_map_base.translation.y(), -200.0, 5.0);
  }
  EXPECT_NE(said.find("minus 457000 5429000 0"), std::string::npos) << said;
  EXPECT_NE(session.configurations().at("import_map").find("origin: [457000, 5429000, 0]"),
            std::string::npos);
}

/// It moved the session's origin half the way to it, where floats are centimetres apart.
TEST_F(ImportedSession, OfAMapInUtmIsNotMovedByAStrayPoint) {
  const Eigen::Vector3d shift(456'700.0, 5'428'800.0, 0.0);
  test::MadeMap map = street();
  map.points.push_back({-shift, 0.5F});
  write_map(options.map, map, shift);
  const Session session = imported();
  EXPECT_NE(said.find("minus 457000 5429000 0"), std::string::npos) << said;
  EXPECT_NE(said.find("none sees them: 1 after thinning"), std::string::npos) << said;
}

TEST_F(ImportedSession, OfALocalMapKeepsItsFrameAndDatumBesideAStrayPoint) {
  test::MadeMap map = street();
  map.points.push_back({{456'700.0, 5'428'800.0, 0.0}, 0.5F});
  write_map(options.map, map);
  options.datum = GeodeticDatum{49.0, 8.0, 100.0};
  const Session session = imported();
  EXPECT_EQ(said.find("minus"), std::string::npos) << said;
  EXPECT_NE(said.find("none sees them: 1 after thinning"), std::string::npos) << said;
  EXPECT_TRUE(session.datum().has_value());
}

TEST_F(ImportedSession, HasNoDatumFarAway) {
  write_map(options.map, street(), {456'700.0, 5'428'800.0, 0.0});
  options.datum = GeodeticDatum{49.0, 8.0, 100.0};
  EXPECT_NE(refusal().find("leave the datum out"), std::string::npos);
}

TEST_F(ImportedSession, NeedsPointsAndGround) {
  write_map(options.map, {});
  EXPECT_NE(refusal().find("has no points"), std::string::npos);
  test::MadeMap wall;
  wall.add_rectangle({0.0, 0.0, 0.0}, {50.0, 0.0, 0.0}, {0.0, 0.0, 5.0});
  write_map(options.map, wall);
  const std::string said_of_wall = refusal();
  EXPECT_NE(said_of_wall.find("no ground is found"), std::string::npos) << said_of_wall;
  EXPECT_NE(said_of_wall.find("--trajectory"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder.path() / "session")) << "nothing is left";
}

TEST_F(ImportedSession, NeedsATrajectoryInTheMap) {
  write_map(options.map, street());
  options.trajectory = folder.path() / "elsewhere.tum";
  std::ofstream(options.trajectory) << "1 900 900 0 0 0 0 1\n";
  EXPECT_NE(refusal().find("both have to be in the same frame"), std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::map_import
