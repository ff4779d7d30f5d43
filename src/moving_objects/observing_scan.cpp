// SPDX-License-Identifier: BSD-3-Clause
#include "observing_scan.hpp"

#include <algorithm>
#include <array>

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kChunk = 1024;     // points that are asked about together
constexpr std::size_t kLanes = 16;       // of the longest vectors
constexpr std::size_t kSettleEvery = 4;  // observers; more often costs more than it saves

/// An observer seen from the key frame in question.
struct Place {
  const RangeImage* image;
  Viewpoint view;
};

/// Points that are asked about, and what was said of each. Arrays are longer than there are cases,
/// so that kernels may work on whole vectors.
struct Cases {
  std::array<float, kChunk> x{}, y{}, z{};  ///< in base_link
  std::array<std::uint32_t, kChunk> points{};
  std::array<int, kChunk> left{};  ///< observers in reach that were not asked yet
  std::array<int, kChunk> through{};
  std::array<int, kChunk> hits{};
  std::size_t size = 0;

  std::size_t padded_size() const { return (size + kLanes - 1) / kLanes * kLanes; }
  PointArrays arrays() const { return {x.data(), y.data(), z.data()}; }

  /// Those of a cloud with these numbers.
  void fill(const PointCloud& cloud, const std::uint32_t* numbers, std::size_t count) {
    for (std::array<int, kChunk>* counts : {&left, &through, &hits}) counts->fill(0);
    for (std::size_t i = 0; i < count; ++i) {
      const Point& point = cloud.points[numbers[i]];
      points[i] = numbers[i];
      x[i] = point.x;
      y[i] = point.y;
      z[i] = point.z;
    }
    size = count;
  }

  void move(std::size_t from, std::size_t to) {
    for (std::array<float, kChunk>* values : {&x, &y, &z}) (*values)[to] = (*values)[from];
    for (std::array<int, kChunk>* counts : {&left, &through, &hits})
      (*counts)[to] = (*counts)[from];
    points[to] = points[from];
  }
};

class VoteCollector {
 public:
  VoteCollector(std::vector<Place> places, const MovingObjectsConfig& config)
      : places_(std::move(places)), needed_(places_.size() + 1) {
    int needed = config.min_votes;
    for (std::size_t votes = 0; votes < needed_.size(); ++votes) {
      while (needed < config.min_share * static_cast<double>(votes)) ++needed;
      needed_[votes] = needed;
    }
  }

  /// Leaves no case behind.
  void judge(Cases& cases, std::vector<Vote>& votes) {
    const std::size_t count = cases.padded_size();
    near_.clear();
    for (const Place& place : places_) {
      const int in_reach =
          visibility_kernels().count_reach(place.view, cases.arrays(), count, cases.left.data());
      if (in_reach > 0) near_.push_back(&place);
    }
    for (std::size_t i = 0; i < near_.size(); ++i) {
      if (i % kSettleEvery == 0) settle(cases, votes);
      if (cases.size == 0) return;
      ask(*near_[i], cases);
    }
    settle(cases, votes);
  }

 private:
  void ask(const Place& place, Cases& cases) {
    const std::size_t count = cases.padded_size();
    const ProjectedPixels targets = {pixels_.data(), nearest_.data(), farthest_.data()};
    visibility_kernels().aim(place.view, cases.arrays(), count, targets, cases.left.data());
    place.image->look(targets, count, {cases.through.data(), cases.hits.data()}, unclear_.data());
  }

  /// Takes away the cases that are certain. Without branches, as nobody foresees which they are: of
  /// the others a verdict is written, too, and written again.
  void settle(Cases& cases, std::vector<Vote>& votes) const {
    std::size_t open = 0;
    for (std::size_t i = 0; i < cases.size; ++i) {
      const int left = cases.left[i];
      const int through = cases.through[i];
      const int hits = cases.hits[i];
      const int needed = needed_[static_cast<std::size_t>(left + through + hits)];
      votes[cases.points[i]] = verdict(through, hits, needed);
      cases.move(i, open);
      open += is_certain(left, through, hits, needed) ? 0 : 1;
    }
    cases.size = open;
  }

  /// Whether the verdict is the same if all that were not asked say one thing or the other.
  static bool is_certain(int left, int through, int hits, int needed) {
    const int stands = (hits > 0 ? 1 : 0) & (through + left < needed ? 1 : 0);
    return ((left == 0 ? 1 : 0) | stands | (through >= needed ? 1 : 0)) != 0;
  }

  /// If all that were not asked say that it stands.
  static Vote verdict(int through, int hits, int needed) {
    const Vote other = through + hits == 0 ? Vote::kUnseen : Vote::kStands;
    return through >= needed ? Vote::kMoves : other;
  }

  const std::vector<Place> places_;
  std::vector<int> needed_;  ///< by the number of votes: how many for that it moves
  std::vector<const Place*> near_;
  std::array<int, kChunk> pixels_{}, nearest_{}, farthest_{}, unclear_{};  ///< of one place
};

Viewpoint view_of(const ObservingScan& observer, const Pose& T_map_base, double reach) {
  const Pose T_sensor_base = observer.T_sensor_map * T_map_base;
  Viewpoint view{};
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(view.R_sensor_points) =
      T_sensor_base.rotation_matrix().cast<float>();
  Eigen::Map<Eigen::Vector3f>(view.p_points_sensor) =
      T_sensor_base.inverse().translation.cast<float>();
  view.squared_reach = static_cast<float>(reach * reach);
  view.first_row = observer.image.first_row();
  view.rows = observer.image.rows();
  return view;
}

std::vector<Place> places_of(const std::vector<const ObservingScan*>& observers,
                             const Pose& T_map_base, double reach) {
  std::vector<Place> places;
  for (const ObservingScan* observer : observers)
    places.push_back({&observer->image, view_of(*observer, T_map_base, reach)});
  return places;
}

}  // namespace

std::vector<Vote> votes_on(const PointCloud& cloud, const Pose& T_map_base,
                           const std::vector<std::uint32_t>& asked,
                           const std::vector<const ObservingScan*>& observers,
                           const MovingObjectsConfig& config) {
  std::vector<Vote> votes(cloud.size(), Vote::kUnseen);
  VoteCollector collector(places_of(observers, T_map_base, config.reach), config);
  Cases cases;
  for (std::size_t i = 0; i < asked.size(); i += kChunk) {
    cases.fill(cloud, asked.data() + i, std::min(kChunk, asked.size() - i));
    collector.judge(cases, votes);
  }
  return votes;
}

}  // namespace lidar_mapping::moving_objects
