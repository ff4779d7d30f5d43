// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// m: largest coordinate that is read from files. Chosen: farther than any point on Earth from any
/// other, so that more is a damaged number; squares of it stay far from the end of the numbers.
constexpr double kMaxCoordinate = 1e9;
/// s since 1970: latest time that is read from files, in the year 2112, because ROS has no later
/// ones than 2106 (its seconds are 32 bits without a sign).
constexpr double kMaxTime = 4.5e9;

/// A number as people and programs write it. Throws InputError for whatever else the word holds:
/// letters behind it, nothing, nan or inf.
double finite_number(const std::string& word);

/// The same for a coordinate or a distance, which is at most kMaxCoordinate.
double coordinate(const std::string& word);

/// A whole number between two others. Throws InputError for any other word.
std::int64_t whole_number(const std::string& word, std::int64_t least, std::int64_t most);

/// Nanoseconds since any epoch as a time. Throws InputError beyond 142 years.
Stamp stamp_of_nanoseconds(const std::string& word);

/// Seconds since any epoch as a time. Throws InputError beyond 142 years (2112, after 1970).
Stamp stamp_of_seconds(double seconds);

/// The same for a word. Digits are taken one by one, because a double would round the stamps of
/// today to a quarter of a microsecond.
Stamp stamp_of_seconds(const std::string& word);

/// From the upper 3x4 of a homogeneous matrix. Throws InputError if it holds no rotation: its axes
/// are to be at right angles and of unit length within 5 %, as many digits as people keep.
Pose rigid_pose(const Eigen::Matrix4d& matrix);

/// All numbers of a text file, between which there is white space. Throws FileError with the line
/// of a word that is no finite number.
std::vector<double> read_numbers(const std::filesystem::path& path);

}  // namespace lidar_mapping
