// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {

namespace {

constexpr std::size_t kTumColumns = 8;     // time x y z qx qy qz qw, by the TUM RGB-D benchmark
constexpr std::size_t kKittiColumns = 12;  // 3 x 4 matrix by rows, by the KITTI odometry benchmark

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

StampedPose from_tum(const std::vector<std::string>& words) {
  double v[kTumColumns];
  for (std::size_t i = 1; i < kTumColumns; ++i) v[i] = coordinate(words[i]);
  const Eigen::Quaterniond rotation(v[7], v[4], v[5], v[6]);
  if (std::abs(rotation.norm() - 1.0) > 0.5) throw InputError("quaternion is not of unit length");
  return {stamp_of_seconds(words[0]), {rotation.normalized(), {v[1], v[2], v[3]}}};
}

Pose from_kitti(const std::vector<std::string>& words) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = coordinate(words[i]);
  return rigid_pose(matrix);
}

void append_line(Trajectory& trajectory, const std::vector<std::string>& words) {
  const bool is_other =
      !trajectory.poses.empty() && trajectory.has_stamps != (words.size() == kTumColumns);
  if (is_other && (words.size() == kTumColumns || words.size() == kKittiColumns)) {
    throw InputError("lines of 8 numbers (TUM) and of 12 (KITTI) are mixed");
  }
  if (words.size() == kTumColumns) {
    trajectory.poses.push_back(from_tum(words));
  } else if (words.size() == kKittiColumns) {
    trajectory.has_stamps = false;
    trajectory.poses.push_back({static_cast<Stamp>(trajectory.poses.size()), from_kitti(words)});
  } else {
    throw InputError("expected 8 numbers (TUM) or 12 (KITTI), found " +
                     std::to_string(words.size()));
  }
}

}  // namespace

void sort_by_stamp(Trajectory& trajectory) {
  std::stable_sort(trajectory.poses.begin(), trajectory.poses.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

std::optional<Pose> pose_between(const StampedPose& before, const StampedPose& after, Stamp stamp,
                                 double largest_gap_s) {
  const double gap = to_seconds(after.stamp - before.stamp);
  if (gap > largest_gap_s) return std::nullopt;
  return interpolate(before.pose, after.pose, to_seconds(stamp - before.stamp) / gap);
}

std::optional<Pose> pose_at(Stamp stamp, const Trajectory& trajectory, double largest_gap_s) {
  const std::vector<StampedPose>& poses = trajectory.poses;
  const auto after = first_not_before(poses, stamp);
  if (after == poses.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == poses.begin()) return std::nullopt;
  return pose_between(*(after - 1), *after, stamp, largest_gap_s);
}

std::string to_tum(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& entry : trajectory.poses) {
    const Eigen::Vector3d& t = entry.pose.translation;
    const Eigen::Quaterniond& q = entry.pose.rotation;
    text += seconds_text(entry.stamp) + formatted(" %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", t.x(),
                                                  t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

std::string to_kitti(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& entry : trajectory.poses) {
    const Eigen::Matrix4d matrix = entry.pose.matrix();
    for (int i = 0; i < 12; ++i) {
      text += formatted("%.12g%c", matrix(i / 4, i % 4), i < 11 ? ' ' : '\n');
    }
  }
  return text;
}

Trajectory read_trajectory(const std::string& path) {
  std::ifstream file = open_for_reading(path);
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty() || words[0][0] == '#') continue;
    try {
      append_line(trajectory, words);
    } catch (const std::exception& error) {
      throw InputError(path + ":" + std::to_string(number) + ": " + error.what() +
                       "; correct or remove the line");
    }
  }
  sort_by_stamp(trajectory);  // the lines of files that were put together may jump back in time
  return trajectory;
}

}  // namespace lidar_mapping
