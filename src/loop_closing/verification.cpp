// SPDX-License-Identifier: BSD-3-Clause
#include "verification.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace lidar_mapping::loop_closing {

namespace {

constexpr float kTestRange = 40.0F;    // m from the scan; further points are too sparse
constexpr float kPairDistance = 0.3F;  // m
constexpr float kPairSearch = 0.6F;    // m, for pairs that lie side by side on one plane

/// Shares of points that agree with a range image.
class SightTally {
 public:
  void add(RangeImage::Sight sight) {
    if (sight == RangeImage::Sight::kUntested) return;
    ++tested_;
    if (sight == RangeImage::Sight::kViolates) ++violating_;
  }
  double share() const { return tested_ == 0 ? 0.0 : static_cast<double>(violating_) / tested_; }

 private:
  int tested_ = 0;
  int violating_ = 0;
};

double smaller_eigenvalue(const Eigen::Matrix2d& scatter, int count) {
  if (count == 0) return 0.0;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter / count).eigenvalues()[0];
}

/// What the query's points and their nearest points in the submap say, a pair at a time.
class PairTally {
 public:
  PairTally(const Submap& submap, float fitness_range)
      : submap_(submap), fitness_range_(fitness_range) {}

  /// `p`: a point of the query in the submap's frame; `pair`: the nearest point there, if any is
  /// near; `tested`: the point is above ground and not far.
  void add(const Eigen::Vector3f& p, const std::optional<KdTree::Neighbour>& pair, bool tested) {
    if (tested) ++tested_;
    if (!pair) return;
    if (pair->squared_distance < fitness_range_ * fitness_range_) {
      sum_of_squares_ += pair->squared_distance;
      ++near_;
    }
    if (!tested || pair->squared_distance >= kPairSearch * kPairSearch) return;
    if (pair->squared_distance < kPairDistance * kPairDistance) ++explained_;
    add_normal(p, pair->index);
  }

  void report(MatchFigures& figures) const {
    figures.tested_points = tested_;
    if (tested_ > 0) figures.overlap = static_cast<double>(explained_) / tested_;
    figures.horizontal_eigenvalue = smaller_eigenvalue(scatter_, normals_);
    figures.fitness =
        near_ == 0 ? static_cast<double>(fitness_range_) * fitness_range_ : sum_of_squares_ / near_;
  }

 private:
  void add_normal(const Eigen::Vector3f& p, std::size_t index) {
    const Eigen::Vector3f& normal = submap_.surface.normal(index);
    if (normal.isZero()) return;
    if (std::abs(normal.dot(p - submap_.surface.tree().points()[index])) > kPairDistance) return;
    const Eigen::Vector2d horizontal = normal.head<2>().cast<double>();
    scatter_ += horizontal * horizontal.transpose();
    ++normals_;
  }

  const Submap& submap_;
  float fitness_range_;
  int tested_ = 0;
  int explained_ = 0;
  int near_ = 0;
  double sum_of_squares_ = 0.0;
  int normals_ = 0;
  Eigen::Matrix2d scatter_ = Eigen::Matrix2d::Zero();
};

/// Overlap, tested points, horizontal eigenvalue and fitness.
void measure_pairs(const QueryScan& query, const Submap& submap,
                   const Eigen::Isometry3f& T_submap_query, float fitness_range,
                   MatchFigures& figures) {
  const float range = std::max(kPairSearch, fitness_range);
  PairTally tally(submap, fitness_range);
  for (std::size_t i = 0; i < query.points.size(); ++i) {
    const Eigen::Vector3f p = T_submap_query * query.points[i];
    const bool tested = query.above_ground[i] && query.points[i].norm() <= kTestRange;
    tally.add(p, submap.surface.tree().nearest(p, range), tested);
  }
  tally.report(figures);
}

double violation_of_query(const QueryScan& query, const Submap& submap,
                          const Eigen::Isometry3f& T_submap_query) {
  SightTally tally;
  for (std::size_t i = 0; i < query.points.size(); ++i) {
    if (!query.above_ground[i]) continue;
    const Eigen::Vector3f p = T_submap_query * query.points[i];
    if (p.norm() < kTestRange) tally.add(submap.image.sight(p));
  }
  return tally.share();
}

double violation_of_submap(const QueryScan& query, const Submap& submap,
                           const Eigen::Isometry3f& T_query_submap) {
  SightTally tally;
  const auto& points = submap.surface.tree().points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!submap.above_ground[i]) continue;
    const Eigen::Vector3f p = T_query_submap * points[i];
    if (p.norm() < kTestRange) tally.add(query.image.sight(p));
  }
  return tally.share();
}

}  // namespace

double roofed_fraction(const Submap& submap) {
  constexpr int kPlaces = 15;        // along each axis
  constexpr float kPlace = 2.0F;     // m
  constexpr float kOverhead = 0.5F;  // m above the LiDAR
  constexpr float kLevel = 0.95F;    // cosine
  std::bitset<kPlaces * kPlaces> seen, roofed;
  const auto& points = submap.surface.tree().points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = points[i] - submap.p_base_lidar;
    const int x = static_cast<int>(std::floor(p.x() / kPlace + 0.5F * kPlaces));
    const int y = static_cast<int>(std::floor(p.y() / kPlace + 0.5F * kPlaces));
    if (x < 0 || y < 0 || x >= kPlaces || y >= kPlaces) continue;
    const auto place = static_cast<std::size_t>(y * kPlaces + x);
    seen[place] = true;
    if (p.z() < kOverhead || roofed[place]) continue;
    roofed[place] = std::abs(submap.surface.normal(i).z()) > kLevel;
  }
  return static_cast<double>(roofed.count()) / std::max(1.0, static_cast<double>(seen.count()));
}

MatchFigures measure_match(const QueryScan& query, const Submap& submap, const Pose& T_submap_query,
                           double fitness_score_max_range) {
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.linear() = T_submap_query.rotation_matrix().cast<float>();
  T.translation() = T_submap_query.translation.cast<float>();
  MatchFigures figures;
  measure_pairs(query, submap, T, static_cast<float>(fitness_score_max_range), figures);
  figures.free_space_violation = std::max(violation_of_query(query, submap, T),
                                          violation_of_submap(query, submap, T.inverse()));
  return figures;
}

}  // namespace lidar_mapping::loop_closing
