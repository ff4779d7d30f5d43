// SPDX-License-Identifier: BSD-3-Clause
#include "pass_registration.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <unordered_map>
#include <utility>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/robust_weights.hpp"

#include "cell_statistics.hpp"

namespace lidar_mapping::map_quality {

namespace {

// m, edges of the cells: large ones find a displacement of up to kMaxPairDistance of their edge,
// small ones hold one surface each. Chosen between that reach and the 0.5 m of the thickness.
constexpr double kCoarseCell = 2.0;
constexpr double kFineCell = 1.0;
// Points for a plane, which has three unknowns. Chosen: more of them lose cells far from a sensor
// with few beams, fewer give normals of noise. The later pass is a single one and has fewer points
// than the earlier ones together.
constexpr double kMinPointsEarlier = 12.0;
constexpr double kMinPointsLater = 8.0;
// m, standard deviation across a plane: five times the range noise of a LiDAR (0.02 m). Chosen:
// less would lose surfaces that the earlier passes have twice, more would admit bushes.
constexpr double kMaxThickness = 0.1;
// Cosine of the angle between the normals of a pair, 20 degrees: chosen above the error of the
// normal of kMinPointsLater points and below the angle between neighbouring surfaces (90 degrees).
constexpr double kCosSimilar = 0.94;
// Distance of the planes of a pair, in edges of the cell: chosen a little above half of the edge,
// beyond which the surface usually lies in the next cell.
constexpr double kMaxPairDistance = 0.6;
// Limits of the iterations. Chosen: they bound the time.
constexpr int kIterations = 5;        // at most, per size of cells and per solution
constexpr int kWideIterations = 3;    // with coarse cells and the wide cutoff
constexpr double kConverged = 0.001;  // m; a tenth of the smallest misalignment of interest
// m, cutoff of Tukey's weights while displacements are still large. Chosen: two thirds of the
// distance that pairs of kCoarseCell may have; pairs near that distance can only be wrong.
constexpr double kWideCutoff = 0.8;
// m, least cutoff afterwards. Chosen: the range noise of a LiDAR, so that a perfect section keeps
// its pairs.
constexpr double kMinCutoff = 0.02;
// Standard deviations up to which a pair has weight: 99.7 % of a normal distribution.
constexpr double kCutoffSigmas = 3.0;
// Least weight of a ground plane: chosen so that without walls the height is still
// determined.
constexpr double kMinGroundWeight = 0.1;
// Planes (sum of their weights) that have to constrain a direction. Chosen: a single plane may be a
// wrong pair, a second one that agrees with it rarely is.
constexpr double kMinConstraints = 2.0;
// m, distance at which a rotation is measured by the shift that it causes. Chosen: that of the
// walls of a street; half of the length of a section would be the least that is meaningful.
constexpr double kLeverArm = 10.0;
// m, distance within which a wall agrees with a shift. Chosen: half more than the range noise.
constexpr double kAgreementDistance = 0.03;
// Ratio of the numbers of agreeing walls. Chosen: 10 % more walls are no coincidence, and the
// search from coarse to fine keeps its result where both are as good.
constexpr double kClearMajority = 1.1;
// Planes for four unknowns. Chosen: nearly four for each, so that no single wrong pair decides.
constexpr std::size_t kMinPlanes = 15;

/// Planes of the cells: one for each side from which points were observed. Normals point to the
/// LiDAR if its position is known.
using Planes = std::unordered_map<VoxelKey, std::vector<Plane>, VoxelKeyHash>;
/// Points of a cell, separated by the side from which they were observed.
struct CellSides {
  Eigen::Vector3d normal;
  PointMoments front;  ///< Points observed against the normal, and those with unknown direction.
  PointMoments back;
};

/// Separates the points by side, because the upper and the lower side of a slab, or the two sides
/// of a thin wall, are two surfaces.
std::unordered_map<VoxelKey, CellSides, VoxelKeyHash> sides_of(const ObservedPoints& points,
                                                               double cell, double min_points) {
  std::unordered_map<VoxelKey, PointMoments, VoxelKeyHash> cells;
  for (const ObservedPoint& point : points)
    cells[cell_key(point.position, cell)].add(point.position);
  std::unordered_map<VoxelKey, CellSides, VoxelKeyHash> sides;
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

Planes planes_of(const ObservedPoints& points, double cell, double min_points) {
  Planes planes;
  for (const auto& [key, sides] : sides_of(points, cell, min_points)) {
    for (const bool front : {true, false}) {
      const PointMoments& moments = front ? sides.front : sides.back;
      if (moments.count < min_points) continue;
      Plane plane = plane_of(moments);
      if (plane.extent < kMinExtent * cell || plane.thickness > kMaxThickness) continue;
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
        if (std::abs(pair.distance) <= kMaxPairDistance * cell) pairs.push_back(pair);
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
  return ground > 0.0 ? std::clamp(others / ground, kMinGroundWeight, 1.0) : 1.0;
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
    const double cutoff =
        is_early ? kWideCutoff
                 : std::max(kMinCutoff, kCutoffSigmas * kSigmaPerMad * residual_of(pairs, shift));
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
void remove_shift(ObservedPoints& points, const Shift& shift) {
  for (ObservedPoint& point : points) {
    point.position -= shift.head<3>() + shift[3] * Eigen::Vector3d::UnitZ().cross(point.position);
  }
}

PassShift register_with_cells(const ObservedPoints& earlier, ObservedPoints later, bool sided,
                              std::initializer_list<double> cells) {
  PassShift result;
  for (const double cell : cells) {
    const Planes planes = planes_of(earlier, cell, kMinPointsEarlier);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      const auto pairs = plane_pairs(planes, planes_of(later, cell, kMinPointsLater), cell, sided);
      result.planes = pairs.size();
      if (!result.is_known()) return result;
      const Shift step = solve(pairs, cell == kCoarseCell && iteration < kWideIterations);
      result.residual = residual_of(pairs, step);
      result.agreeing_walls = agreeing_walls(pairs, step);
      result.shift += step;
      remove_shift(later, step);
      if (step.head<3>().norm() < kConverged) break;
    }
  }
  return result;
}

}  // namespace

bool PassShift::is_known() const { return planes >= kMinPlanes; }

// From coarse to fine cells, which finds large displacements. If clearly more walls agree after a
// registration with fine cells alone, that is the result: where surfaces stand in rows, as cars do
// in a car park, coarse cells match one with the next.
PassShift register_passes(const ObservedPoints& earlier, const ObservedPoints& later, bool sided) {
  const PassShift fine = register_with_cells(earlier, later, sided, {kFineCell});
  const PassShift coarse_to_fine =
      register_with_cells(earlier, later, sided, {kCoarseCell, kFineCell});
  if (!coarse_to_fine.is_known()) return fine;
  const bool coarse_start_failed =
      static_cast<double>(fine.agreeing_walls) >
      kClearMajority * static_cast<double>(coarse_to_fine.agreeing_walls);
  return coarse_start_failed ? fine : coarse_to_fine;
}

}  // namespace lidar_mapping::map_quality
