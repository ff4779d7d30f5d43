#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <Eigen/Cholesky>

#include "lidar_mapping/map/map_quality.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map {

namespace {

constexpr double kPlaceLength = 10.0;        // m of the later pass
constexpr double kNearby = 10.0;             // m between the passes
constexpr double kApart = 40.0;              // m of way between the passes
constexpr std::size_t kMostPoints = 80'000;  // of a pass and place
constexpr int kRounds = 5;
constexpr double kConverged = 0.001;   // m
constexpr double kMaxThickness = 0.1;  // m, of a plane
constexpr std::size_t kMinPlanes = 15;
constexpr double kCosSimilar = 0.94;  // normals within 20 degrees

using Points = std::vector<Eigen::Vector3d>;
using Planes = std::unordered_map<std::int64_t, Plane>;
/// Translation, then yaw about the place's centre.
using Shift = Eigen::Vector4d;

Planes planes_of(const Points& points, double cell, double min_points) {
  std::unordered_map<std::int64_t, Moments> cells;
  for (const Eigen::Vector3d& point : points) cells[cell_key(point, cell)].add(point);
  Planes planes;
  for (const auto& [key, moments] : cells) {
    if (moments.count < min_points) continue;
    const Plane plane = plane_of(moments);
    if (plane.extent < 0.15 * cell || plane.thickness > kMaxThickness) continue;
    planes.emplace(key, plane);
  }
  return planes;
}

/// A plane of the earlier pass and how far the later pass lies beside it.
struct Pair {
  Eigen::Vector4d row;
  double distance;
  bool ground;
};

/// In the order of the keys, so that sums do not depend on the order of a hash table.
std::vector<Pair> pairs_of(const Planes& earlier, const Planes& later, double cell) {
  std::vector<std::int64_t> keys;
  for (const auto& [key, plane] : earlier) {
    if (later.count(key) > 0) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Pair> pairs;
  for (const std::int64_t key : keys) {
    const Plane& a = earlier.at(key);
    const Plane& b = later.at(key);
    if (std::abs(a.normal.dot(b.normal)) < kCosSimilar) continue;
    const double distance = a.normal.dot(b.centre - a.centre);
    if (std::abs(distance) > 0.6 * cell) continue;
    const Eigen::Vector3d turned = Eigen::Vector3d::UnitZ().cross(b.centre);
    Pair pair;
    pair.row << a.normal, a.normal.dot(turned);
    pair.distance = distance;
    pair.ground = is_ground(a);
    pairs.push_back(pair);
  }
  return pairs;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double residual_of(const std::vector<Pair>& pairs, const Shift& shift) {
  std::vector<double> distances;
  for (const Pair& pair : pairs) {
    distances.push_back(std::abs(pair.distance - pair.row.dot(shift)));
  }
  return median_of(distances);
}

double tukey(double residual, double cut) {
  const double ratio = residual / cut;
  return std::abs(ratio) >= 1.0 ? 0.0 : std::pow(1.0 - ratio * ratio, 2.0);
}

/// Ground planes together count no more than all others: they are many and say nothing sideways.
double ground_weight(const std::vector<Pair>& pairs) {
  double ground = 0.0;
  for (const Pair& pair : pairs) ground += pair.ground ? 1.0 : 0.0;
  const double others = static_cast<double>(pairs.size()) - ground;
  return ground > 0.0 ? std::clamp(others / ground, 0.1, 1.0) : 1.0;
}

Shift solve(const std::vector<Pair>& pairs, bool first_rounds) {
  const double for_ground = ground_weight(pairs);
  Shift shift = Shift::Zero();
  for (int round = 0; round < kRounds; ++round) {
    const double cut =
        first_rounds ? 0.8 : std::max(0.02, 3.0 * 1.4826 * residual_of(pairs, shift));
    Eigen::Matrix4d information = Eigen::Vector4d(0.01, 0.01, 0.01, 1.0).asDiagonal();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Pair& pair : pairs) {
      const double weight =
          (pair.ground ? for_ground : 1.0) * tukey(pair.distance - pair.row.dot(shift), cut);
      information += weight * pair.row * pair.row.transpose();
      right += weight * pair.row * pair.distance;
    }
    shift = information.ldlt().solve(right);
  }
  return shift;
}

/// Moves the later pass back.
void take_back(Points& points, const Shift& shift) {
  for (Eigen::Vector3d& point : points) {
    point -= shift.head<3>() + shift[3] * Eigen::Vector3d::UnitZ().cross(point);
  }
}

struct Registration {
  Shift shift = Shift::Zero();
  std::size_t planes = 0;
  double residual = 0.0;
};

/// How far `later` lies beside `earlier`; both relative to the place's centre.
Registration registered(const Points& earlier, Points later) {
  Registration result;
  for (const double cell : {2.0, 1.0}) {
    const Planes planes = planes_of(earlier, cell, 12);
    for (int round = 0; round < kRounds; ++round) {
      const auto pairs = pairs_of(planes, planes_of(later, cell, 8), cell);
      result.planes = pairs.size();
      if (pairs.size() < kMinPlanes) return result;
      const Shift step = solve(pairs, cell > 1.5 && round < 3);
      result.residual = residual_of(pairs, step);
      result.shift += step;
      take_back(later, step);
      if (step.head<3>().norm() < kConverged) break;
    }
  }
  return result;
}

/// Places along the way and what is near them.
class Places {
 public:
  Places(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config)
      : poses_(poses.poses), clouds_(clouds), config_(config) {
    double way = 0.0;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (i > 0) way += (position(i) - position(i - 1)).norm();
      ways_.push_back(way);
    }
  }

  std::vector<GhostVector> all() const {
    std::vector<GhostVector> vectors;
    for (const Place& place : places()) {
      const Registration found =
          registered(points_of(place.earlier, place), points_of(place.later, place));
      if (found.planes >= kMinPlanes) vectors.push_back(vector_of(place, found));
    }
    return vectors;
  }

  PlacePoints points_at(KeyFrameIndex index) const {
    for (const Place& place : places()) {
      if (poses_[place.middle].index != index) continue;
      return {in_vehicle(points_of(place.earlier, place), place),
              in_vehicle(points_of(place.later, place), place)};
    }
    return {};
  }

 private:
  /// Key frames of the later pass, and the earlier ones near them.
  struct Place {
    std::size_t middle;
    std::vector<std::size_t> earlier;
    std::vector<std::size_t> later;
  };

  std::vector<Place> places() const {
    std::vector<Place> places;
    for (std::size_t begin = 0; begin < poses_.size();) {
      std::size_t end = begin + 1;
      while (end < poses_.size() && ways_[end] - ways_[begin] < kPlaceLength) ++end;
      Place place{(begin + end) / 2, earlier_ones(begin, end), {}};
      for (std::size_t i = begin; i < end; ++i) place.later.push_back(i);
      if (place.earlier.size() >= 2) places.push_back(place);
      begin = end;
    }
    return places;
  }

  const Eigen::Vector3d& position(std::size_t i) const { return poses_[i].T_map_base.translation; }

  std::vector<std::size_t> earlier_ones(std::size_t begin, std::size_t end) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < begin && ways_[begin] - ways_[i] > kApart; ++i) {
      for (std::size_t j = begin; j < end; ++j) {
        if ((position(i) - position(j)).norm() > kNearby) continue;
        found.push_back(i);
        break;
      }
    }
    return found;
  }

  /// Relative to the place's middle.
  Points points_of(const std::vector<std::size_t>& members, const Place& place) const {
    const Eigen::Vector3d centre = position(place.middle);
    Points points;
    for (const std::size_t member : members) {
      const PointCloudPtr cloud = clouds_.cloud(poses_[member].index);
      if (!cloud) continue;
      const std::size_t share = kMostPoints / members.size() + 1;
      const std::size_t step = cloud->size() / share + 1;
      for (std::size_t i = 0; i < cloud->size(); i += step) {
        const Eigen::Vector3d p_base = cloud->points[i].position().cast<double>();
        if (p_base.norm() > config_.reach) continue;
        points.push_back(poses_[member].T_map_base * p_base - centre);
      }
    }
    return points;
  }

  Eigen::Quaterniond heading_back(const Place& place) const {
    return exp_so3({0.0, 0.0, -yaw_of(poses_[place.middle].T_map_base.rotation)});
  }

  GhostVector vector_of(const Place& place, const Registration& found) const {
    const Eigen::Vector3d t = heading_back(place) * Eigen::Vector3d(found.shift.head<3>());
    return {poses_[place.middle].index,
            position(place.middle),
            t.x(),
            t.y(),
            t.z(),
            found.shift[3],
            found.planes,
            found.residual};
  }

  std::vector<Eigen::Vector3f> in_vehicle(const Points& points, const Place& place) const {
    const Eigen::Quaterniond turn = heading_back(place);
    std::vector<Eigen::Vector3f> turned;
    for (const Eigen::Vector3d& point : points) turned.push_back((turn * point).cast<float>());
    return turned;
  }

  const std::vector<KeyFramePose>& poses_;
  CloudSource& clouds_;
  const QualityConfig config_;
  std::vector<double> ways_;  ///< m from the start
};

}  // namespace

std::vector<GhostVector> ghost_vectors(const KeyFramePoses& poses, CloudSource& clouds,
                                       const QualityConfig& config) {
  return Places(poses, clouds, config).all();
}

PlacePoints place_points(const KeyFramePoses& poses, CloudSource& clouds,
                         const QualityConfig& config, const GhostVector& place) {
  return Places(poses, clouds, config).points_at(place.key_frame);
}

}  // namespace lidar_mapping::map
