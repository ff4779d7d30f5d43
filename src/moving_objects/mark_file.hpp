// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "lidar_mapping/common/nameless_file.hpp"
#include "lidar_mapping/common/point_cloud.hpp"

namespace lidar_mapping::moving_objects {

/// Indices of points in ascending order.
using Marks = std::vector<std::uint32_t>;

/// The points of a cloud with these indices.
PointCloudPtr marked_points(const PointCloud& cloud, const Marks& marks);
/// All other points of a cloud.
PointCloudPtr unmarked_points(const PointCloud& cloud, const Marks& marks);

/// Marked points of each key frame, in an unnamed temporary file in a folder. Throws FileError.
class MarkFile {
 public:
  explicit MarkFile(std::filesystem::path directory) : directory_(std::move(directory)) {}

  bool contains(std::size_t position) const { return spans_.count(position) > 0; }
  /// Stores the marks of a key frame; may be called once for each.
  void put(std::size_t position, const Marks& marks);
  Marks get(std::size_t position) const;

 private:
  struct Span {
    std::uint64_t begin = 0;  ///< Position of the first mark in the file, in marks.
    std::size_t count = 0;
  };

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::uint64_t end_ = 0;  ///< Length of the file, in marks.
  std::map<std::size_t, Span> spans_;
};

}  // namespace lidar_mapping::moving_objects
