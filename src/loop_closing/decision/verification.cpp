// SPDX-License-Identifier: BSD-3-Clause
#include "decision/verification.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"

namespace lidar_mapping::loop_closing {

namespace {

constexpr float kTestRange = 40.0F;  // m from the scan; chosen: beyond it points are too sparse
// m. Chosen: voxel size of a submap plus the error of a match.
constexpr float kPairDistance = 0.3F;
// m, for pairs that are side by side on one plane: twice kPairDistance; chosen
constexpr float kPairSearch = 0.6F;

bool is_in_view(const Eigen::Vector3f& p, const Submap& submap) {
  return submap.view == nullptr || submap.view->contains(p, submap.p_base_lidar);
}

double smaller_eigenvalue(const Eigen::Matrix2d& scatter, int count) {
  if (count == 0) return 0.0;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter / count).eigenvalues()[0];
}

/// Accumulates the figures of pairs of a query point and its nearest point in the submap.
class PairStatistics {
 public:
  PairStatistics(const Submap& submap, float fitness_range)
      : submap_(submap), fitness_range_(fitness_range) {}

  /// Adds one point: `p` is a point of the query in the submap's frame, `pair` the nearest point
  /// there, if one is near. `tested` is true if the point is above ground, not too far away, and
  /// where the LiDAR of the submap can see.
  void add(const Eigen::Vector3f& p, const std::optional<KdTree::Neighbour>& pair, bool tested) {
    if (tested) ++tested_;
    if (!pair) return;
    if (pair->squared_distance < fitness_range_ * fitness_range_) {
      sum_of_squares_ += pair->squared_distance;
      ++paired_;
    }
    if (!tested || pair->squared_distance >= kPairSearch * kPairSearch) return;
    if (pair->squared_distance < kPairDistance * kPairDistance) ++overlapping_;
    add_normal(p, pair->index);
  }

  void report(MatchFigures& figures) const {
    figures.tested_points = tested_;
    if (tested_ > 0) figures.overlap = static_cast<double>(overlapping_) / tested_;
    figures.horizontal_eigenvalue = smaller_eigenvalue(scatter_, normal_count_);
    figures.fitness = paired_ == 0 ? static_cast<double>(fitness_range_) * fitness_range_
                                   : sum_of_squares_ / paired_;
  }

 private:
  void add_normal(const Eigen::Vector3f& p, std::size_t index) {
    const Eigen::Vector3f& normal = submap_.surface.normal(index);
    if (normal.isZero()) return;
    if (std::abs(normal.dot(p - submap_.surface.tree().points()[index])) > kPairDistance) return;
    const Eigen::Vector2d horizontal = normal.head<2>().cast<double>();
    scatter_ += horizontal * horizontal.transpose();
    ++normal_count_;
  }

  const Submap& submap_;
  float fitness_range_;
  int tested_ = 0;
  int overlapping_ = 0;
  int paired_ = 0;
  double sum_of_squares_ = 0.0;
  int normal_count_ = 0;
  Eigen::Matrix2d scatter_ = Eigen::Matrix2d::Zero();
};

/// Measures overlap, tested points, horizontal eigenvalue and fitness.
void measure_pairs(const QueryScan& query, const Submap& submap,
                   const Eigen::Isometry3f& T_submap_query, float fitness_range,
                   MatchFigures& figures) {
  const float range = std::max(kPairSearch, fitness_range);
  PairStatistics statistics(submap, fitness_range);
  for (std::size_t i = 0; i < query.points.size(); ++i) {
    const Eigen::Vector3f p = T_submap_query * query.points[i];
    const bool tested =
        query.above_ground[i] && query.points[i].norm() <= kTestRange && is_in_view(p, submap);
    statistics.add(p, submap.surface.tree().nearest(p, range), tested);
  }
  statistics.report(figures);
}

/// Fraction of the points above ground in space that the other side saw as free, of those that its
/// image can test.
double violation_fraction(const std::vector<Eigen::Vector3f>& points,
                          const std::vector<bool>& is_above_ground, const FreeSpaceImage& image,
                          const Eigen::Isometry3f& T_image_points) {
  using FreeSpaceTest = FreeSpaceImage::FreeSpaceTest;
  int tested = 0;
  int violating = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_above_ground[i]) continue;
    const Eigen::Vector3f p = T_image_points * points[i];
    if (!(p.norm() < kTestRange)) continue;
    const FreeSpaceTest result = image.test_free_space(p);
    tested += result == FreeSpaceTest::kUntested ? 0 : 1;
    violating += result == FreeSpaceTest::kViolation ? 1 : 0;
  }
  return tested == 0 ? 0.0 : static_cast<double>(violating) / tested;
}

}  // namespace

double free_space_violation(const SingleView& a, const SingleView& b, const Pose& T_a_b) {
  const Eigen::Isometry3f T = isometry(T_a_b);
  return std::max(violation_fraction(b.points, b.above_ground, a.image, T),
                  violation_fraction(a.points, a.above_ground, b.image, T.inverse()));
}

double roofed_fraction(const Submap& submap) {
  // Cells of 2 m in a square of 30 m with the LiDAR in its middle. Chosen: beyond, ceilings are
  // seen too flat to have normals, and smaller cells stay empty between rings.
  constexpr int kCellsPerAxis = 15;
  constexpr float kCellSize = 2.0F;
  constexpr float kMinHeight = 0.5F;    // m above the LiDAR; chosen: cars beside it are lower
  constexpr float kMinNormalZ = 0.95F;  // cosine of 18 degrees; chosen: ramps are flatter
  std::bitset<kCellsPerAxis * kCellsPerAxis> occupied, roofed;
  const auto& points = submap.surface.tree().points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points[i] - submap.p_base_lidar;
    const int x = floor_to_int(p.x() / kCellSize + 0.5F * kCellsPerAxis);
    const int y = floor_to_int(p.y() / kCellSize + 0.5F * kCellsPerAxis);
    if (x < 0 || y < 0 || x >= kCellsPerAxis || y >= kCellsPerAxis) continue;
    const auto cell = static_cast<std::size_t>(y * kCellsPerAxis + x);
    occupied[cell] = true;
    if (p.z() < kMinHeight || roofed[cell]) continue;
    roofed[cell] = std::abs(submap.surface.normal(i).z()) > kMinNormalZ;
  }
  return static_cast<double>(roofed.count()) / std::max(1.0, static_cast<double>(occupied.count()));
}

MatchFigures measure_match(const QueryScan& query, const Submap& submap, const Pose& T_submap_query,
                           double fitness_score_max_range) {
  const Eigen::Isometry3f T = isometry(T_submap_query);
  MatchFigures figures;
  measure_pairs(query, submap, T, static_cast<float>(fitness_score_max_range), figures);
  figures.sight = std::min(query.sight, submap.sight);
  figures.free_space_violation =
      std::max(violation_fraction(query.points, query.above_ground, submap.image, T),
               violation_fraction(submap.surface.tree().points(), submap.above_ground, query.image,
                                  T.inverse()));
  return figures;
}

}  // namespace lidar_mapping::loop_closing
