// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "lidar_mapping/common/pose.hpp"

namespace lidar_mapping::preprocessing {

/// T_base_frame of a sensor's frame; empty while it is not known.
using ExtrinsicLookup = std::function<std::optional<Pose>(const std::string& frame_id)>;

/// Looks up the pose of a sensor until it is found, then stores it: sensors are fixed to the
/// vehicle.
class Extrinsics {
 public:
  /// `lookup` is asked again for a frame until it gives a pose.
  explicit Extrinsics(ExtrinsicLookup lookup) : lookup_(std::move(lookup)) {}

  /// Pose of the sensor's frame in base_link; empty while it is not known or not finite.
  std::optional<Pose> T_base(const std::string& frame_id) const {
    const auto known = known_.find(frame_id);
    if (known != known_.end()) return known->second;
    const auto found = lookup_(frame_id);
    if (!found || !is_finite(*found)) return std::nullopt;
    return known_.emplace(frame_id, *found).first->second;
  }

 private:
  ExtrinsicLookup lookup_;
  mutable std::map<std::string, Pose> known_;
};

}  // namespace lidar_mapping::preprocessing
