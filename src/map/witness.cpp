#include "witness.hpp"

#include <algorithm>

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kChunk = 1024;  // points that are asked about together

/// A witness seen from the key frame in question.
struct Place {
  const RangeImage* image;
  Eigen::Matrix3f R_sensor_base;
  Eigen::Vector3f p_base_sensor;
};

/// A point, and what was said of it.
struct Case {
  Eigen::Vector3f p_base;
  std::uint32_t point = 0;
  int left = 0;  ///< witnesses in reach that were not asked yet
  int through = 0;
  int hits = 0;
};

class Court {
 public:
  Court(std::vector<Place> places, const MovingObjectsConfig& config)
      : places_(std::move(places)), config_(config) {}

  void judge(std::vector<Case>& cases, std::vector<Vote>& votes) const {
    count_reach(cases);
    for (const Place& place : places_) {
      ask(place, cases);
      const auto is_settled = [&](const Case& one) {
        const bool settled = is_certain(one);
        if (settled) votes[one.point] = verdict(one);
        return settled;
      };
      cases.erase(std::remove_if(cases.begin(), cases.end(), is_settled), cases.end());
    }
    for (const Case& one : cases) votes[one.point] = verdict(one);
    cases.clear();
  }

 private:
  bool is_in_reach(const Eigen::Vector3f& from_sensor) const {
    const auto reach = static_cast<float>(config_.reach);
    return from_sensor.squaredNorm() <= reach * reach;
  }

  void count_reach(std::vector<Case>& cases) const {
    for (const Place& place : places_) {
      for (Case& one : cases) {
        one.left += is_in_reach(one.p_base - place.p_base_sensor) ? 1 : 0;
      }
    }
  }

  void ask(const Place& place, std::vector<Case>& cases) const {
    for (Case& one : cases) {
      const Eigen::Vector3f from_sensor = one.p_base - place.p_base_sensor;
      if (!is_in_reach(from_sensor)) continue;
      --one.left;
      const Sight sight = place.image->sight_of(place.R_sensor_base * from_sensor);
      one.through += sight == Sight::kSeenThrough ? 1 : 0;
      one.hits += sight == Sight::kHit ? 1 : 0;
    }
  }

  bool moves(int through, int hits) const {
    return through >= config_.min_votes && through >= config_.min_share * (through + hits);
  }

  /// Whether the verdict is the same if all that were not asked say one thing or the other.
  bool is_certain(const Case& one) const {
    if (one.left == 0) return true;
    if (one.hits > 0 && !moves(one.through + one.left, one.hits)) return true;
    return moves(one.through, one.hits + one.left);
  }

  Vote verdict(const Case& one) const {
    if (one.through + one.hits == 0) return Vote::kUnseen;
    return moves(one.through, one.hits) ? Vote::kMoves : Vote::kStands;
  }

  const std::vector<Place> places_;
  const MovingObjectsConfig& config_;
};

std::vector<Place> places_of(const std::vector<const Witness*>& witnesses, const Pose& T_map_base) {
  std::vector<Place> places;
  for (const Witness* witness : witnesses) {
    const Pose T_sensor_base = witness->T_sensor_map * T_map_base;
    places.push_back({&witness->image, T_sensor_base.rotation_matrix().cast<float>(),
                      T_sensor_base.inverse().translation.cast<float>()});
  }
  return places;
}

}  // namespace

std::vector<Vote> votes_on(const PointCloud& cloud, const Pose& T_map_base,
                           const std::vector<bool>& asked,
                           const std::vector<const Witness*>& witnesses,
                           const MovingObjectsConfig& config) {
  std::vector<Vote> votes(cloud.size(), Vote::kUnseen);
  const Court court(places_of(witnesses, T_map_base), config);
  std::vector<Case> cases;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (asked[i]) cases.push_back({cloud.points[i].position(), static_cast<std::uint32_t>(i)});
    if (cases.size() == kChunk) court.judge(cases, votes);
  }
  court.judge(cases, votes);
  return votes;
}

}  // namespace lidar_mapping::map
