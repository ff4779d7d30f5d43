// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "lidar_mapping/moving_objects/change_list.hpp"

#include "marks.hpp"
#include "visibility/observing_scan.hpp"

namespace lidar_mapping::moving_objects {

/// What other visits have observed at the points of a key frame.
class PointHistory {
 public:
  /// `own`: the visit of the key frame.
  PointHistory(std::size_t own, std::size_t points)
      : own_(static_cast<std::uint32_t>(own)), points_(points) {}

  /// Adds the votes of another visit, and the indices of the points that it has looked through,
  /// neighbouring points decided together.
  void add(std::uint32_t visit, const std::vector<Vote>& votes, const Marks& absent);

  /// Set if the last later visit that observed the location of a point looked through it.
  std::optional<PointChange> disappeared(std::uint32_t point) const;
  /// Set if the visits before looked through the location; those in which it was occupied already
  /// lie between.
  std::optional<PointChange> appeared(std::uint32_t point) const;

 private:
  enum class Observation : char { kNothing, kOccupied, kAbsent };
  using Observations = std::vector<Observation>;  // of all points by one visit

  std::uint32_t own_;
  std::size_t points_;
  std::map<std::uint32_t, Observations> earlier_;
  std::map<std::uint32_t, Observations> later_;
};

}  // namespace lidar_mapping::moving_objects
