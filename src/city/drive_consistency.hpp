// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::city {

/// By how much GNSS of two drives disagrees with the loops between them.
struct GnssDisagreement {
  std::size_t a = 0;                                 ///< number of a drive
  std::size_t b = 0;                                 ///< number of the other drive
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< median over the loops, east and north, m
  double limit = 0.0;                                ///< what the claimed accuracy allows, m
  /// True if the offset is larger than allowed.
  bool is_contradiction() const { return offset.norm() > limit; }
};

/// Largest offset (m) that GNSS of two drives may have to their loops; the arguments are the median
/// claimed standard deviations of both, m.
double allowed_offset(double stddev_a, double stddev_b);

/// A drive whose GNSS is not to be used, and why.
struct ContradictingGnss {
  std::size_t drive = 0;         ///< its number
  std::size_t other_drive = 0;   ///< a drive that it contradicts
  double offset = 0.0;           ///< by how much it contradicts that one, m
  std::size_t contradicted = 0;  ///< number of drives that it contradicts
  std::size_t confirmed = 0;     ///< number of drives that it agrees with
};

/// The drives whose GNSS contradicts that of others: as long as two drives disagree, the one that
/// disagrees with the most others is left out; if that is a draw, the one that agrees with fewer,
/// and then the later one.
std::vector<ContradictingGnss> contradicting_gnss(std::vector<GnssDisagreement> disagreements);

/// What the graph says about the loops between one drive and all others.
struct LoopUsage {
  std::size_t used = 0;     ///< loops that the graph uses
  std::size_t refused = 0;  ///< loops that contradict the graph
};

/// The drive that contradicts the others most: more of its loops to them are refused than used, and
/// at least three. Returns usages.size() if there is none.
std::size_t contradicting_drive(const std::vector<LoopUsage>& usages);

}  // namespace lidar_mapping::city
