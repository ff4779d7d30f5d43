#include "witness.hpp"

#include <algorithm>

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kChunk = 1024;     // points that are asked about together
constexpr std::size_t kSettleEvery = 4;  // witnesses; more often costs more than it saves

/// A witness seen from the key frame in question.
struct Place {
  const RangeImage* image;
  Viewpoint view;
};

/// Points that are asked about, and what was said of each.
struct Cases {
  std::vector<float> x, y, z;  ///< in base_link
  std::vector<std::uint32_t> points;
  std::vector<int> left;  ///< witnesses in reach that were not asked yet
  std::vector<int> through;
  std::vector<int> hits;

  std::size_t size() const { return points.size(); }
  PointArrays arrays() const { return {x.data(), y.data(), z.data()}; }

  /// Those of a cloud with these numbers.
  void fill(const PointCloud& cloud, const std::uint32_t* numbers, std::size_t count) {
    resize(0);
    resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Point& point = cloud.points[numbers[i]];
      points[i] = numbers[i];
      x[i] = point.x;
      y[i] = point.y;
      z[i] = point.z;
    }
  }

  void resize(std::size_t count) {
    for (std::vector<float>* values : {&x, &y, &z}) values->resize(count);
    points.resize(count);
    for (std::vector<int>* counts : {&left, &through, &hits}) counts->resize(count);
  }

  void move(std::size_t from, std::size_t to) {
    for (std::vector<float>* values : {&x, &y, &z}) (*values)[to] = (*values)[from];
    for (std::vector<int>* counts : {&left, &through, &hits}) (*counts)[to] = (*counts)[from];
    points[to] = points[from];
  }
};

class Court {
 public:
  Court(std::vector<Place> places, const MovingObjectsConfig& config)
      : places_(std::move(places)), config_(config) {}

  /// Leaves no case behind.
  void judge(Cases& cases, std::vector<Vote>& votes) {
    for (const Place& place : places_)
      sight_kernels().count_reach(place.view, cases.arrays(), cases.size(), cases.left.data());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (i % kSettleEvery == 0) settle(cases, votes);
      ask(places_[i], cases);
    }
    settle(cases, votes);
  }

 private:
  void ask(const Place& place, Cases& cases) {
    const std::size_t count = cases.size();
    for (std::vector<int>* values : {&pixels_, &nearest_, &farthest_, &unclear_})
      values->resize(count);
    const Aims aims = {pixels_.data(), nearest_.data(), farthest_.data()};
    sight_kernels().aim(place.view, cases.arrays(), count, aims, cases.left.data());
    place.image->look(aims, count, {cases.through.data(), cases.hits.data()}, unclear_.data());
  }

  /// Takes away the cases that are certain.
  void settle(Cases& cases, std::vector<Vote>& votes) const {
    std::size_t open = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (is_certain(cases.left[i], cases.through[i], cases.hits[i])) {
        votes[cases.points[i]] = verdict(cases.through[i], cases.hits[i]);
      } else {
        cases.move(i, open++);
      }
    }
    cases.resize(open);
  }

  bool moves(int through, int hits) const {
    return through >= config_.min_votes && through >= config_.min_share * (through + hits);
  }

  /// Whether the verdict is the same if all that were not asked say one thing or the other.
  bool is_certain(int left, int through, int hits) const {
    if (left == 0) return true;
    if (hits > 0 && !moves(through + left, hits)) return true;
    return moves(through, hits + left);
  }

  Vote verdict(int through, int hits) const {
    if (through + hits == 0) return Vote::kUnseen;
    return moves(through, hits) ? Vote::kMoves : Vote::kStands;
  }

  const std::vector<Place> places_;
  const MovingObjectsConfig& config_;
  std::vector<int> pixels_, nearest_, farthest_, unclear_;  ///< of one place
};

Viewpoint view_of(const Witness& witness, const Pose& T_map_base, double reach) {
  const Pose T_sensor_base = witness.T_sensor_map * T_map_base;
  Viewpoint view{};
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(view.R_sensor_points) =
      T_sensor_base.rotation_matrix().cast<float>();
  Eigen::Map<Eigen::Vector3f>(view.p_points_sensor) =
      T_sensor_base.inverse().translation.cast<float>();
  view.squared_reach = static_cast<float>(reach * reach);
  view.first_row = witness.image.first_row();
  view.rows = witness.image.rows();
  return view;
}

std::vector<Place> places_of(const std::vector<const Witness*>& witnesses, const Pose& T_map_base,
                             double reach) {
  std::vector<Place> places;
  for (const Witness* witness : witnesses)
    places.push_back({&witness->image, view_of(*witness, T_map_base, reach)});
  return places;
}

}  // namespace

std::vector<Vote> votes_on(const PointCloud& cloud, const Pose& T_map_base,
                           const std::vector<std::uint32_t>& asked,
                           const std::vector<const Witness*>& witnesses,
                           const MovingObjectsConfig& config) {
  std::vector<Vote> votes(cloud.size(), Vote::kUnseen);
  Court court(places_of(witnesses, T_map_base, config.reach), config);
  Cases cases;
  for (std::size_t i = 0; i < asked.size(); i += kChunk) {
    cases.fill(cloud, asked.data() + i, std::min(kChunk, asked.size() - i));
    court.judge(cases, votes);
  }
  return votes;
}

}  // namespace lidar_mapping::map
