// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/robust_weights.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map_quality {

namespace {

constexpr double kPlaceLength = 10.0;        // m of the later pass
constexpr double kNearby = 10.0;             // m between the passes
constexpr double kStorey = 2.0;              // m of height between them; it is another storey then
constexpr double kApart = 40.0;              // m of way between the passes
constexpr std::size_t kMostPoints = 80'000;  // of a pass and place
constexpr int kRounds = 5;
constexpr double kConverged = 0.001;   // m
constexpr double kMaxThickness = 0.1;  // m, of a plane
constexpr double kDetermined = 2.0;    // planes that face a direction
constexpr double kLever = 10.0;        // m
constexpr double kAgreeing = 0.03;     // m
constexpr double kClearly = 1.1;       // times as many that agree
constexpr std::size_t kMinPlanes = 15;
constexpr double kCosSimilar = 0.94;  // normals within 20 degrees

/// A point and the direction of the ray that saw it.
struct SeenPoint {
  Eigen::Vector3d position;
  Eigen::Vector3d beam;  ///< zero where nobody knows it
};

using Points = std::vector<SeenPoint>;
/// Of each cell one plane for either side from which points were seen; normals show to the LiDAR,
/// where its place is known.
using Planes = std::unordered_map<VoxelKey, std::vector<Plane>>;
/// Translation, then yaw about the place's centre.
using Shift = Eigen::Vector4d;

/// Those of a cell, once they are told apart.
struct Sides {
  Eigen::Vector3d normal;
  PointMoments front;  ///< seen against the normal, and what was seen from nobody knows where
  PointMoments back;
};

/// The upper and the lower side of a slab, or the two of a thin wall, are two surfaces.
std::unordered_map<VoxelKey, Sides> sides_of(const Points& points, double cell, double min_points) {
  std::unordered_map<VoxelKey, PointMoments> cells;
  for (const SeenPoint& point : points) cells[cell_key(point.position, cell)].add(point.position);
  std::unordered_map<VoxelKey, Sides> sides;
  for (const auto& [key, moments] : cells) {
    if (moments.count >= min_points) sides[key].normal = plane_of(moments).normal;
  }
  for (const SeenPoint& point : points) {
    const auto found = sides.find(cell_key(point.position, cell));
    if (found == sides.end()) continue;
    Sides& of_cell = found->second;
    (of_cell.normal.dot(point.beam) <= 0.0 ? of_cell.front : of_cell.back).add(point.position);
  }
  return sides;
}

Planes planes_of(const Points& points, double cell, double min_points) {
  Planes planes;
  for (const auto& [key, sides] : sides_of(points, cell, min_points)) {
    for (const bool front : {true, false}) {
      const PointMoments& moments = front ? sides.front : sides.back;
      if (moments.count < min_points) continue;
      Plane plane = plane_of(moments);
      if (plane.extent < 0.15 * cell || plane.thickness > kMaxThickness) continue;
      if ((plane.normal.dot(sides.normal) > 0.0) != front) plane.normal *= -1.0;
      planes[key].push_back(plane);
    }
  }
  return planes;
}

/// A plane of the earlier pass and how far the later pass lies beside it.
struct Pair {
  Eigen::Vector4d row;
  double distance;
  bool ground;
};

Pair pair_of(const Plane& a, const Plane& b) {
  const Eigen::Vector3d turned = Eigen::Vector3d::UnitZ().cross(b.centre);
  Pair pair;
  pair.row << a.normal, a.normal.dot(turned);
  pair.distance = a.normal.dot(b.centre - a.centre);
  pair.ground = is_ground(a);
  return pair;
}

/// In the order of the keys, so that sums do not depend on the order of a hash table. Only surfaces
/// that were seen from the same side are the same; `sided` is false where nobody knows the sides.
std::vector<Pair> pairs_of(const Planes& earlier, const Planes& later, double cell, bool sided) {
  std::vector<VoxelKey> keys;
  for (const auto& [key, planes] : earlier) {
    if (later.count(key) > 0) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Pair> pairs;
  for (const VoxelKey key : keys) {
    for (const Plane& a : earlier.at(key)) {
      for (const Plane& b : later.at(key)) {
        const double cosine = a.normal.dot(b.normal);
        if ((sided ? cosine : std::abs(cosine)) < kCosSimilar) continue;
        const Pair pair = pair_of(a, b);
        if (std::abs(pair.distance) <= 0.6 * cell) pairs.push_back(pair);
      }
    }
  }
  return pairs;
}

double residual_of(const std::vector<Pair>& pairs, const Shift& shift) {
  std::vector<double> distances;
  for (const Pair& pair : pairs) {
    distances.push_back(std::abs(pair.distance - pair.row.dot(shift)));
  }
  return median(std::move(distances));
}

/// Upright planes only: nearly all that is level agrees however far one lies beside the other.
std::size_t agreeing(const std::vector<Pair>& pairs, const Shift& shift) {
  return static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) {
    return !pair.ground && std::abs(pair.distance - pair.row.dot(shift)) < kAgreeing;
  }));
}

/// Ground planes together count no more than all others: they are many and say nothing sideways.
double ground_weight(const std::vector<Pair>& pairs) {
  double ground = 0.0;
  for (const Pair& pair : pairs) ground += pair.ground ? 1.0 : 0.0;
  const double others = static_cast<double>(pairs.size()) - ground;
  return ground > 0.0 ? std::clamp(others / ground, 0.1, 1.0) : 1.0;
}

/// What the planes say; zero where they say next to nothing, as ground does of what is sideways.
Shift determined_part(const Eigen::Matrix4d& information, const Eigen::Vector4d& right) {
  // Turning counts as the shift that it makes at some distance.
  const Eigen::Vector4d unit(1.0, 1.0, 1.0, 1.0 / kLever);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(unit.asDiagonal() * information *
                                                              unit.asDiagonal());
  Shift shift = Shift::Zero();
  for (int i = 0; i < 4; ++i) {
    if (solver.eigenvalues()[i] < kDetermined) continue;
    const Eigen::Vector4d direction = solver.eigenvectors().col(i);
    shift += direction * direction.dot(unit.cwiseProduct(right)) / solver.eigenvalues()[i];
  }
  return unit.cwiseProduct(shift);
}

Shift solve(const std::vector<Pair>& pairs, bool first_rounds) {
  const double for_ground = ground_weight(pairs);
  Shift shift = Shift::Zero();
  for (int round = 0; round < kRounds; ++round) {
    const double cut =
        first_rounds ? 0.8 : std::max(0.02, 3.0 * 1.4826 * residual_of(pairs, shift));
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Pair& pair : pairs) {
      const double weight =
          (pair.ground ? for_ground : 1.0) * tukey_weight(pair.distance - pair.row.dot(shift), cut);
      information += weight * pair.row * pair.row.transpose();
      right += weight * pair.row * pair.distance;
    }
    shift = determined_part(information, right);
  }
  return shift;
}

/// Moves the later pass back.
void take_back(Points& points, const Shift& shift) {
  for (SeenPoint& point : points) {
    point.position -= shift.head<3>() + shift[3] * Eigen::Vector3d::UnitZ().cross(point.position);
  }
}

struct Registration {
  Shift shift = Shift::Zero();
  std::size_t planes = 0;    ///< fewer than kMinPlanes: nothing is known
  std::size_t agreeing = 0;  ///< upright ones
  double residual = 0.0;
};

/// Finds how far one pass lies beside another; both relative to the place's centre.
class PassRegistration {
 public:
  PassRegistration(const Points& earlier, const Points& later, bool sided)
      : earlier_(earlier), later_(later), sided_(sided) {}

  /// A displacement that large cells find first, unless clearly more walls agree where small ones
  /// alone lead, from the passes as they lie. Where surfaces stand in rows, as cars do in a car
  /// park, large cells take one for the next.
  Registration best() const {
    const Registration near = refined({1.0});
    const Registration far = refined({2.0, 1.0});
    if (far.planes < kMinPlanes) return near;
    const bool far_was_astray =
        static_cast<double>(near.agreeing) > kClearly * static_cast<double>(far.agreeing);
    return far_was_astray ? near : far;
  }

 private:
  Registration refined(std::initializer_list<double> cells) const {
    Registration result;
    Points later = later_;
    for (const double cell : cells) {
      const Planes planes = planes_of(earlier_, cell, 12);
      for (int round = 0; round < kRounds; ++round) {
        const auto pairs = pairs_of(planes, planes_of(later, cell, 8), cell, sided_);
        result.planes = pairs.size();
        if (pairs.size() < kMinPlanes) return result;
        const Shift step = solve(pairs, cell > 1.5 && round < 3);
        result.residual = residual_of(pairs, step);
        result.agreeing = agreeing(pairs, step);
        result.shift += step;
        take_back(later, step);
        if (step.head<3>().norm() < kConverged) break;
      }
    }
    return result;
  }

  const Points& earlier_;
  const Points& later_;
  bool sided_;
};

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
      const Points earlier = points_of(place.earlier, place);
      const Points later = points_of(place.later, place);
      const Registration found =
          PassRegistration(earlier, later, config_.p_base_sensor.has_value()).best();
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
        const Eigen::Vector3d between = position(i) - position(j);
        if (between.norm() > kNearby || std::abs(between.z()) > kStorey) continue;
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
      const Pose& T_map_base = poses_[member].T_map_base;
      const std::size_t share = kMostPoints / members.size() + 1;
      const std::size_t step = cloud->size() / share + 1;
      for (std::size_t i = 0; i < cloud->size(); i += step) {
        const Eigen::Vector3d p_base = cloud->points[i].position().cast<double>();
        if (p_base.norm() > config_.reach) continue;
        points.push_back({T_map_base * p_base - centre, T_map_base.rotation * beam_to(p_base)});
      }
    }
    return points;
  }

  Eigen::Vector3d beam_to(const Eigen::Vector3d& p_base) const {
    if (!config_.p_base_sensor) return Eigen::Vector3d::Zero();
    return p_base - *config_.p_base_sensor;
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
    for (const SeenPoint& point : points) {
      turned.push_back((turn * point.position).cast<float>());
    }
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

}  // namespace lidar_mapping::map_quality
