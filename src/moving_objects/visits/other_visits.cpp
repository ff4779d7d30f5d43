// SPDX-License-Identifier: BSD-3-Clause
#include "visits/other_visits.hpp"

#include <algorithm>

namespace lidar_mapping::moving_objects {

OtherVisits::OtherVisits(const std::vector<KeyFramePose>& poses, const Visits& visits) {
  for (Position i = 0; i < poses.size(); ++i) {
    places_.push_back(poses[i].T_map_base.translation);
    visits_.push_back(static_cast<std::uint32_t>(visits.visit_of(i)));
    cells_[cell_of(i)].push_back(i);
  }
}

VoxelKey OtherVisits::cell_of(Position position) const {
  return voxel_key(voxel_index(places_[position] / kRadius));
}

std::map<std::uint32_t, std::vector<OtherVisits::Position>> OtherVisits::candidates(
    Position position) const {
  std::map<std::uint32_t, std::vector<Position>> found;
  for_voxels_around(cell_of(position), [&](VoxelKey key) {
    const auto cell = cells_.find(key);
    if (cell == cells_.end()) return;
    for (const Position other : cell->second) {
      if (visits_[other] == visits_[position]) continue;
      if ((places_[other] - places_[position]).norm() > kRadius) continue;
      found[visits_[other]].push_back(other);
    }
  });
  return found;
}

std::map<std::uint32_t, std::vector<OtherVisits::Position>> OtherVisits::near(
    Position position) const {
  std::map<std::uint32_t, std::vector<Position>> observers;
  const auto distance = [&](Position other) {
    return (places_[other] - places_[position]).squaredNorm();
  };
  for (auto& [visit, positions] : candidates(position)) {
    std::sort(positions.begin(), positions.end(), [&](Position a, Position b) {
      return std::make_pair(distance(a), a) < std::make_pair(distance(b), b);
    });
    std::vector<Position>& chosen = observers[visit];
    for (const Position candidate : positions) {
      const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](Position other) {
        return (places_[other] - places_[candidate]).norm() >= kSpacing;
      });
      if (is_apart) chosen.push_back(candidate);
    }
  }
  return observers;
}

}  // namespace lidar_mapping::moving_objects
