#include "witness.hpp"

#include <algorithm>

namespace lidar_mapping::map {

namespace {

constexpr std::size_t kChunk = 1024;     // points that are asked about together
constexpr std::size_t kSettleEvery = 4;  // witnesses; more often costs more than it saves

/// A witness seen from the key frame in question.
struct Place {
  const RangeImage* image;
  Eigen::Matrix3f R_sensor_base;
  Eigen::Vector3f p_base_sensor;
};

/// Points that are asked about, and what was said of each.
struct Cases {
  SensorPoints p_base;
  std::vector<std::uint32_t> points;
  std::vector<int> left;  ///< witnesses in reach that were not asked yet
  std::vector<int> through;
  std::vector<int> hits;

  std::size_t size() const { return points.size(); }

  /// Those of a cloud with these numbers.
  void fill(const PointCloud& cloud, const std::uint32_t* numbers, std::size_t count) {
    resize(0);
    resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Point& point = cloud.points[numbers[i]];
      points[i] = numbers[i];
      p_base.x[i] = point.x;
      p_base.y[i] = point.y;
      p_base.z[i] = point.z;
    }
  }

  void resize(std::size_t count) {
    p_base.resize(count);
    points.resize(count);
    for (std::vector<int>* counts : {&left, &through, &hits}) counts->resize(count);
  }

  void move(std::size_t from, std::size_t to) {
    for (std::vector<float>* values : {&p_base.x, &p_base.y, &p_base.z})
      (*values)[to] = (*values)[from];
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
    for (const Place& place : places_) count_reach(place, cases);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (i % kSettleEvery == 0) settle(cases, votes);
      ask(places_[i], cases);
    }
    settle(cases, votes);
  }

 private:
  float squared_reach() const { return static_cast<float>(config_.reach * config_.reach); }

  void count_reach(const Place& place, Cases& cases) const {
    const float* x = cases.p_base.x.data();
    const float* y = cases.p_base.y.data();
    const float* z = cases.p_base.z.data();
    int* left = cases.left.data();
    const Eigen::Vector3f c = place.p_base_sensor;
    const float reach = squared_reach();
    for (std::size_t i = 0; i < cases.size(); ++i) left[i] += squared(x[i], y[i], z[i], c) <= reach;
  }

  static float squared(float x, float y, float z, const Eigen::Vector3f& c) {
    return (x - c.x()) * (x - c.x()) + (y - c.y()) * (y - c.y()) + (z - c.z()) * (z - c.z());
  }

  void ask(const Place& place, Cases& cases) {
    gather(place, cases);
    directions_.project(seen_);
    place.image->look(directions_, sights_);
    for (std::size_t k = 0; k < asked_.size(); ++k) {
      const std::size_t i = asked_[k];
      const Sight sight = sights_[k];
      --cases.left[i];
      cases.through[i] += sight == Sight::kSeenThrough ? 1 : 0;
      cases.hits[i] += sight == Sight::kHit ? 1 : 0;
    }
  }

  /// The cases in reach of a place, as they are seen from there.
  void gather(const Place& place, const Cases& cases) {
    const std::size_t count = cases.size();
    const SensorPoints& p = cases.p_base;
    const Eigen::Vector3f c = place.p_base_sensor;
    asked_.resize(count);
    seen_.resize(count);
    std::size_t asked = 0;  // without branches: in or out of reach alternate along a wall
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3f p_sensor =
          place.R_sensor_base * (Eigen::Vector3f(p.x[i], p.y[i], p.z[i]) - c);
      asked_[asked] = static_cast<std::uint32_t>(i);
      seen_.x[asked] = p_sensor.x();
      seen_.y[asked] = p_sensor.y();
      seen_.z[asked] = p_sensor.z();
      asked += squared(p.x[i], p.y[i], p.z[i], c) <= squared_reach();
    }
    asked_.resize(asked);
    seen_.resize(asked);
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
  std::vector<std::uint32_t> asked_;  ///< what follows is that of one place
  SensorPoints seen_;
  Directions directions_;
  std::vector<Sight> sights_;
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
  Court court(places_of(witnesses, T_map_base), config);
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (asked[i]) numbers.push_back(static_cast<std::uint32_t>(i));
  }
  Cases cases;
  for (std::size_t i = 0; i < numbers.size(); i += kChunk) {
    cases.fill(cloud, numbers.data() + i, std::min(kChunk, numbers.size() - i));
    court.judge(cases, votes);
  }
  return votes;
}

}  // namespace lidar_mapping::map
