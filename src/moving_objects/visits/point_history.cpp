// SPDX-License-Identifier: BSD-3-Clause
#include "visits/point_history.hpp"

namespace lidar_mapping::moving_objects {

void PointHistory::add(std::uint32_t visit, const std::vector<Vote>& votes, const Marks& absent) {
  Observations& observations = (visit < own_ ? earlier_ : later_)[visit];
  observations.assign(points_, Observation::kNothing);
  for (std::size_t i = 0; i < points_; ++i) {
    if (votes[i] == Vote::kStatic) observations[i] = Observation::kOccupied;
  }
  for (const std::uint32_t point : absent) observations[point] = Observation::kAbsent;
}

std::optional<PointChange> PointHistory::disappeared(std::uint32_t point) const {
  std::optional<std::uint32_t> absent;
  std::uint32_t present = own_;
  for (auto visit = later_.rbegin(); visit != later_.rend(); ++visit) {
    const Observation observation = visit->second[point];
    if (observation == Observation::kOccupied) {
      present = visit->first;
      break;
    }
    if (observation == Observation::kAbsent) absent = visit->first;
  }
  if (!absent) return std::nullopt;
  return PointChange{ChangeKind::kDisappeared, *absent, present};
}

std::optional<PointChange> PointHistory::appeared(std::uint32_t point) const {
  std::uint32_t present = own_;
  for (auto visit = earlier_.rbegin(); visit != earlier_.rend(); ++visit) {
    const Observation observation = visit->second[point];
    if (observation == Observation::kAbsent) {
      return PointChange{ChangeKind::kAppeared, visit->first, present};
    }
    if (observation == Observation::kOccupied) present = visit->first;
  }
  return std::nullopt;
}

}  // namespace lidar_mapping::moving_objects
