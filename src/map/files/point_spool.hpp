// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/list_file.hpp"

namespace lidar_mapping::map {

/// A point of the map on its way into a file.
struct StoredPoint {
  std::array<std::int32_t, 3> position{};  ///< In a MillimetreFrame.
  float intensity = 0.0F;                  ///< As the sensor gives it.
  KeyFrameIndex key_frame = 0;             ///< Of the first observation.
};

/// Points that wait in an unnamed file in a folder, in their order. The file is made with the first
/// of them that the memory does not hold. Throws FileError.
class PointSpool {
 public:
  explicit PointSpool(std::filesystem::path directory) : parts_(std::move(directory)) {}

  void add(const StoredPoint& point);
  std::size_t size() const { return stored_ + buffer_.size(); }
  /// Passes all points to `visit` with their numbers from 0 on.
  void for_each(const std::function<void(std::size_t number, const StoredPoint&)>& visit) const;
  /// All points, at the end of `points`.
  void append_to(std::vector<StoredPoint>& points) const;

 private:
  ListFile<std::size_t, StoredPoint> parts_;
  std::size_t stored_ = 0;  ///< Points in the file.
  std::vector<StoredPoint> buffer_;
};

}  // namespace lidar_mapping::map
