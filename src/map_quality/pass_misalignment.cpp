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

constexpr double kSectionLength = 10.0;    // m, length of a section of the later pass
constexpr double kMaxPassDistance = 10.0;  // m, largest distance between the passes
// Metres; larger height differences belong to another storey.
constexpr double kMaxHeightDifference = 2.0;
constexpr double kMinPathBetweenPasses = 40.0;     // m, least path length between the passes
constexpr std::size_t kMaxPointsPerPass = 80'000;  // per pass and section
constexpr int kIterations = 5;                     // at most; chosen, bounds the time
constexpr double kConverged = 0.001;               // m
constexpr double kMaxThickness = 0.1;              // m, of a plane
constexpr double kMinConstraints = 2.0;            // number of planes that have to face a direction
constexpr double kLeverArm = 10.0;                 // m
constexpr double kAgreementDistance = 0.03;        // m
constexpr double kClearMajority = 1.1;             // ratio of the numbers of agreeing walls
constexpr std::size_t kMinPlanes = 15;             // chosen, for four unknowns
constexpr double kCosSimilar = 0.94;               // normals within 20 degrees

/// A point with the direction of the ray that measured it.
struct ObservedPoint {
  Eigen::Vector3d position;
  Eigen::Vector3d beam;  ///< Zero if unknown.
};

using Points = std::vector<ObservedPoint>;
/// Planes of the cells: one for each side from which points were observed. Normals point to the
/// LiDAR if its position is known.
using Planes = std::unordered_map<VoxelKey, std::vector<Plane>>;
/// Translation (m), then yaw (rad) about the centre of the section.
using Shift = Eigen::Vector4d;

/// Points of a cell, separated by the side from which they were observed.
struct CellSides {
  Eigen::Vector3d normal;
  PointMoments front;  ///< Points observed against the normal, and those with unknown direction.
  PointMoments back;
};

/// Separates the points by side, because the upper and the lower side of a slab, or the two sides
/// of a thin wall, are two surfaces.
std::unordered_map<VoxelKey, CellSides> sides_of(const Points& points, double cell,
                                                 double min_points) {
  std::unordered_map<VoxelKey, PointMoments> cells;
  for (const ObservedPoint& point : points)
    cells[cell_key(point.position, cell)].add(point.position);
  std::unordered_map<VoxelKey, CellSides> sides;
  for (const auto& [key, moments] : cells) {
    if (moments.count >= min_points) sides[key].normal = plane_of(moments).normal;
  }
  for (const ObservedPoint& point : points) {
    const auto found = sides.find(cell_key(point.position, cell));
    if (found == sides.end()) continue;
    CellSides& cell_sides = found->second;
    (cell_sides.normal.dot(point.beam) <= 0.0 ? cell_sides.front : cell_sides.back)
        .add(point.position);
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

/// A plane of the earlier pass and its distance to the matching plane of the later pass; `row` is
/// the derivative of the distance with respect to the shift.
struct PlanePair {
  Eigen::Vector4d row;
  double distance;
  bool ground;
};

PlanePair plane_pair(const Plane& a, const Plane& b) {
  const Eigen::Vector3d rotated = Eigen::Vector3d::UnitZ().cross(b.centre);
  PlanePair pair;
  pair.row << a.normal, a.normal.dot(rotated);
  pair.distance = a.normal.dot(b.centre - a.centre);
  pair.ground = is_ground(a);
  return pair;
}

/// Pairs of matching planes in the order of the keys, so that sums do not depend on the order of a
/// hash table. Surfaces match only if they were observed from the same side; `sided` is false if
/// the sides are unknown.
std::vector<PlanePair> plane_pairs(const Planes& earlier, const Planes& later, double cell,
                                   bool sided) {
  std::vector<VoxelKey> keys;
  for (const auto& [key, planes] : earlier) {
    if (later.count(key) > 0) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<PlanePair> pairs;
  for (const VoxelKey key : keys) {
    for (const Plane& a : earlier.at(key)) {
      for (const Plane& b : later.at(key)) {
        const double cosine = a.normal.dot(b.normal);
        if ((sided ? cosine : std::abs(cosine)) < kCosSimilar) continue;
        const PlanePair pair = plane_pair(a, b);
        if (std::abs(pair.distance) <= 0.6 * cell) pairs.push_back(pair);
      }
    }
  }
  return pairs;
}

double residual_of(const std::vector<PlanePair>& pairs, const Shift& shift) {
  std::vector<double> distances;
  for (const PlanePair& pair : pairs) {
    distances.push_back(std::abs(pair.distance - pair.row.dot(shift)));
  }
  return median(std::move(distances));
}

/// Number of walls that agree with a shift. Ground planes are not counted, because nearly all of
/// them agree with any horizontal shift.
std::size_t agreeing_walls(const std::vector<PlanePair>& pairs, const Shift& shift) {
  return static_cast<std::size_t>(
      std::count_if(pairs.begin(), pairs.end(), [&](const PlanePair& pair) {
        return !pair.ground && std::abs(pair.distance - pair.row.dot(shift)) < kAgreementDistance;
      }));
}

/// Weight of ground planes. All of them together weigh no more than all others, because they are
/// many and do not constrain horizontal shifts.
double ground_weight(const std::vector<PlanePair>& pairs) {
  double ground = 0.0;
  for (const PlanePair& pair : pairs) ground += pair.ground ? 1.0 : 0.0;
  const double others = static_cast<double>(pairs.size()) - ground;
  return ground > 0.0 ? std::clamp(others / ground, 0.1, 1.0) : 1.0;
}

/// The part of the shift that the planes constrain; zero along directions that they hardly
/// constrain, such as horizontal ones in a map of ground alone.
Shift constrained_part(const Eigen::Matrix4d& information, const Eigen::Vector4d& right_hand_side) {
  // A rotation is measured by the shift that it causes at some distance.
  const Eigen::Vector4d unit(1.0, 1.0, 1.0, 1.0 / kLeverArm);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(unit.asDiagonal() * information *
                                                              unit.asDiagonal());
  Shift shift = Shift::Zero();
  for (int i = 0; i < 4; ++i) {
    if (solver.eigenvalues()[i] < kMinConstraints) continue;
    const Eigen::Vector4d direction = solver.eigenvectors().col(i);
    shift +=
        direction * direction.dot(unit.cwiseProduct(right_hand_side)) / solver.eigenvalues()[i];
  }
  return unit.cwiseProduct(shift);
}

Shift solve(const std::vector<PlanePair>& pairs, bool is_early) {
  const double weight_of_ground = ground_weight(pairs);
  Shift shift = Shift::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double cutoff = is_early ? 0.8 : std::max(0.02, 3.0 * 1.4826 * residual_of(pairs, shift));
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right_hand_side = Eigen::Vector4d::Zero();
    for (const PlanePair& pair : pairs) {
      const double weight = (pair.ground ? weight_of_ground : 1.0) *
                            tukey_weight(pair.distance - pair.row.dot(shift), cutoff);
      information += weight * pair.row * pair.row.transpose();
      right_hand_side += weight * pair.row * pair.distance;
    }
    shift = constrained_part(information, right_hand_side);
  }
  return shift;
}

/// Removes the shift from the later pass.
void remove_shift(Points& points, const Shift& shift) {
  for (ObservedPoint& point : points) {
    point.position -= shift.head<3>() + shift[3] * Eigen::Vector3d::UnitZ().cross(point.position);
  }
}

struct Registration {
  Shift shift = Shift::Zero();
  std::size_t planes = 0;          ///< With fewer than kMinPlanes the shift is unknown.
  std::size_t agreeing_walls = 0;  ///< Number of agreeing walls.
  double residual = 0.0;
};

/// Finds the shift of one pass against another; both are relative to the centre of the section.
class PassRegistration {
 public:
  PassRegistration(const Points& earlier, const Points& later, bool sided)
      : earlier_(earlier), later_(later), sided_(sided) {}

  /// Registers from coarse to fine cells, which finds large displacements. If clearly more walls
  /// agree after a registration with fine cells alone, that is the result: where surfaces stand in
  /// rows, as cars do in a car park, coarse cells match one with the next.
  Registration registered() const {
    const Registration fine = register_with_cells({1.0});
    const Registration coarse_to_fine = register_with_cells({2.0, 1.0});
    if (coarse_to_fine.planes < kMinPlanes) return fine;
    const bool coarse_start_failed =
        static_cast<double>(fine.agreeing_walls) >
        kClearMajority * static_cast<double>(coarse_to_fine.agreeing_walls);
    return coarse_start_failed ? fine : coarse_to_fine;
  }

 private:
  Registration register_with_cells(std::initializer_list<double> cells) const {
    Registration result;
    Points later = later_;
    for (const double cell : cells) {
      const Planes planes = planes_of(earlier_, cell, 12);
      for (int iteration = 0; iteration < kIterations; ++iteration) {
        const auto pairs = plane_pairs(planes, planes_of(later, cell, 8), cell, sided_);
        result.planes = pairs.size();
        if (pairs.size() < kMinPlanes) return result;
        const Shift step = solve(pairs, cell > 1.5 && iteration < 3);
        result.residual = residual_of(pairs, step);
        result.agreeing_walls = agreeing_walls(pairs, step);
        result.shift += step;
        remove_shift(later, step);
        if (step.head<3>().norm() < kConverged) break;
      }
    }
    return result;
  }

  const Points& earlier_;
  const Points& later_;
  bool sided_;
};

/// Sections of the path that the vehicle has passed before, and the points around them.
class RevisitedSections {
 public:
  RevisitedSections(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config)
      : poses_(poses.poses), clouds_(clouds), config_(config) {
    double path_length = 0.0;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (i > 0) path_length += (position(i) - position(i - 1)).norm();
      path_lengths_.push_back(path_length);
    }
  }

  std::vector<PassMisalignment> misalignments() const {
    std::vector<PassMisalignment> result;
    for (const Section& section : sections()) {
      const Points earlier = points_of(section.earlier, section);
      const Points later = points_of(section.later, section);
      const Registration found =
          PassRegistration(earlier, later, config_.p_base_sensor.has_value()).registered();
      if (found.planes >= kMinPlanes) result.push_back(misalignment_of(section, found));
    }
    return result;
  }

  PassPoints points_at(KeyFrameIndex index) const {
    for (const Section& section : sections()) {
      if (poses_[section.middle].index != index) continue;
      return {in_vehicle_axes(points_of(section.earlier, section), section),
              in_vehicle_axes(points_of(section.later, section), section)};
    }
    return {};
  }

 private:
  /// Key frames of the later pass, and the earlier ones near them, as positions in poses_.
  struct Section {
    std::size_t middle;
    std::vector<std::size_t> earlier;
    std::vector<std::size_t> later;
  };

  std::vector<Section> sections() const {
    std::vector<Section> sections;
    for (std::size_t begin = 0; begin < poses_.size();) {
      std::size_t end = begin + 1;
      while (end < poses_.size() && path_lengths_[end] - path_lengths_[begin] < kSectionLength)
        ++end;
      Section section{(begin + end) / 2, earlier_key_frames(begin, end), {}};
      for (std::size_t i = begin; i < end; ++i) section.later.push_back(i);
      if (section.earlier.size() >= 2) sections.push_back(section);
      begin = end;
    }
    return sections;
  }

  const Eigen::Vector3d& position(std::size_t i) const { return poses_[i].T_map_base.translation; }

  std::vector<std::size_t> earlier_key_frames(std::size_t begin, std::size_t end) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0;
         i < begin && path_lengths_[begin] - path_lengths_[i] > kMinPathBetweenPasses; ++i) {
      for (std::size_t j = begin; j < end; ++j) {
        const Eigen::Vector3d between = position(i) - position(j);
        if (between.norm() > kMaxPassDistance || std::abs(between.z()) > kMaxHeightDifference)
          continue;
        found.push_back(i);
        break;
      }
    }
    return found;
  }

  /// Points relative to the middle of the section.
  Points points_of(const std::vector<std::size_t>& members, const Section& section) const {
    const Eigen::Vector3d centre = position(section.middle);
    Points points;
    for (const std::size_t member : members) {
      const PointCloudPtr cloud = clouds_.cloud(poses_[member].index);
      if (!cloud) continue;
      const Pose& T_map_base = poses_[member].T_map_base;
      const std::size_t points_per_member = kMaxPointsPerPass / members.size() + 1;
      const std::size_t step = cloud->size() / points_per_member + 1;
      for (std::size_t i = 0; i < cloud->size(); i += step) {
        const Eigen::Vector3d p_base = cloud->points[i].position().cast<double>();
        if (p_base.norm() > config_.max_range) continue;
        points.push_back({T_map_base * p_base - centre, T_map_base.rotation * beam_to(p_base)});
      }
    }
    return points;
  }

  Eigen::Vector3d beam_to(const Eigen::Vector3d& p_base) const {
    if (!config_.p_base_sensor) return Eigen::Vector3d::Zero();
    return p_base - *config_.p_base_sensor;
  }

  Eigen::Quaterniond R_vehicle_map(const Section& section) const {
    return exp_so3({0.0, 0.0, -yaw_of(poses_[section.middle].T_map_base.rotation)});
  }

  PassMisalignment misalignment_of(const Section& section, const Registration& found) const {
    const Eigen::Vector3d t = R_vehicle_map(section) * Eigen::Vector3d(found.shift.head<3>());
    return {poses_[section.middle].index,
            position(section.middle),
            t.x(),
            t.y(),
            t.z(),
            found.shift[3],
            found.planes,
            found.residual};
  }

  std::vector<Eigen::Vector3f> in_vehicle_axes(const Points& points, const Section& section) const {
    const Eigen::Quaterniond rotation = R_vehicle_map(section);
    std::vector<Eigen::Vector3f> rotated;
    for (const ObservedPoint& point : points) {
      rotated.push_back((rotation * point.position).cast<float>());
    }
    return rotated;
  }

  const std::vector<KeyFramePose>& poses_;
  CloudSource& clouds_;
  const QualityConfig config_;
  std::vector<double> path_lengths_;  ///< Path length from the start to each key frame, m.
};

}  // namespace

std::vector<PassMisalignment> pass_misalignments(const KeyFramePoses& poses, CloudSource& clouds,
                                                 const QualityConfig& config) {
  return RevisitedSections(poses, clouds, config).misalignments();
}

PassPoints pass_points(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config,
                       const PassMisalignment& misalignment) {
  return RevisitedSections(poses, clouds, config).points_at(misalignment.key_frame);
}

}  // namespace lidar_mapping::map_quality
