// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::session {

inline Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Pose pose;
  pose.translation = {1e4 * normal(random), 1e4 * normal(random), normal(random)};
  pose.rotation = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                      .normalized();
  return pose;
}

inline PointCloudPtr example_cloud(int points, int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<float> uniform(-50.0F, 50.0F);
  auto cloud = std::make_shared<PointCloud>();
  for (int i = 0; i < points; ++i) {
    cloud->points.push_back({uniform(random), uniform(random), uniform(random), uniform(random)});
  }
  return cloud;
}

inline KeyFrame example_key_frame(KeyFrameIndex index) {
  std::mt19937 random(index);
  KeyFrame key_frame;
  key_frame.index = index;
  key_frame.segment = index / 10;
  key_frame.stamp = 1'317'646'533'000'000'001 + Stamp{index} * 123'456'789;
  key_frame.T_odom_base = random_pose(random);
  key_frame.motion_covariance = diagonal_covariance(0.1, 0.01);
  key_frame.motion_covariance(0, 5) = 0.001;
  key_frame.degenerate_directions = {Eigen::Vector3d::UnitX()};
  key_frame.doubtful = index % 2 == 0;
  key_frame.cloud = example_cloud(100, static_cast<int>(index));
  return key_frame;
}

inline Loop example_loop(KeyFrameIndex from, KeyFrameIndex to) {
  std::mt19937 random(to);
  Loop loop;
  loop.from = from;
  loop.to = to;
  loop.stamp = example_key_frame(to).stamp;
  loop.T_from_to = random_pose(random);
  loop.covariance = diagonal_covariance(0.05, 0.002);
  loop.fitness = 0.07;
  loop.overlap = 0.83;
  loop.source = LoopSource::kAppearance;
  return loop;
}

/// Changes the database of a session as damage or an older version would.
inline void execute(const std::filesystem::path& folder, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "session.db").c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
  sqlite3_close(database);
}

inline void expect_equal(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
}

inline void expect_equal(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.points[i].position(), b.points[i].position());
    EXPECT_EQ(a.points[i].intensity, b.points[i].intensity);
  }
}

}  // namespace lidar_mapping::session
