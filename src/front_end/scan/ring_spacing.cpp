// SPDX-License-Identifier: BSD-3-Clause
#include "scan/ring_spacing.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Number of points that are used. Chosen: seven for each ring of 64 in each sector.
constexpr std::size_t kEnough = 16000;
/// Chosen: within one sector, even a slightly tilted sensor sees each ring at a single elevation.
constexpr std::size_t kSectors = 36;
constexpr std::size_t kBins = 900;  // kBin each, so that they reach from -45 to 45 degrees
/// Of elevation, rad. Chosen: a third of what the narrowest rings are apart (a third of a degree).
constexpr double kBin = 0.1 * kRadPerDeg;
/// Chosen: at shorter ranges an error of the origin changes the elevation too much (1 cm by more
/// than kBin).
constexpr double kMinRange = 3.0;  // m
// Chosen: the quartile of fewer sectors, or the mean spacing of fewer rings, is one of chance.
constexpr std::size_t kLeastSectors = 6;
constexpr int kLeastRings = 4;
/// If a larger fraction of the bins is occupied, the rings cannot be separated. Chosen: that of the
/// narrowest rings (3.3 bins apart) with two bins each, as a ring on the border of bins has.
constexpr double kMostOccupied = 0.6;

/// Radius (m) of an open field around the place where a direction was not observed. Tried: without
/// such fields 2 of 40 simulated starts stood still silently, after 35 and 50 m.
constexpr double kOpenFieldRadius = 60.0;

using Sector = std::bitset<kBins>;

/// The elevations at which a scan has points, from -45 to 45 degrees.
std::array<Sector, kSectors> observed_elevations(const PointCloud& cloud,
                                                 const Eigen::Vector3d& p_base_sensor) {
  std::array<Sector, kSectors> observed;
  const std::size_t step = (cloud.size() / kEnough) | 1U;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3d p = cloud.points[i].position().cast<double>() - p_base_sensor;
    if (!p.allFinite() || p.norm() < kMinRange) continue;
    const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y()));
    const double bin = elevation / kBin + kBins / 2.0;
    if (bin < 0.0 || bin >= kBins) continue;
    const double turn = std::atan2(p.y(), p.x()) / (2.0 * kPi) + 0.5;
    const auto sector = static_cast<std::size_t>(turn * kSectors);
    observed[std::min(sector, kSectors - 1)].set(static_cast<std::size_t>(bin));
  }
  return observed;
}

/// Number of bins from the lowest to the highest occupied one, per run of occupied bins. 0 if too
/// many bins are occupied to separate rings; negative if there are too few rings to decide.
double bins_per_ring(const Sector& sector) {
  int first = -1, last = -1, runs = 0;
  for (int i = 0; i < static_cast<int>(kBins); ++i) {
    if (!sector[i]) continue;
    if (first < 0) first = i;
    if (last < 0 || last + 1 < i) ++runs;
    last = i;
  }
  if (runs == 0) return -1.0;
  if (static_cast<double>(sector.count()) > kMostOccupied * (last + 1 - first)) return 0.0;
  return runs < kLeastRings ? -1.0 : static_cast<double>(last - first) / (runs - 1);
}

}  // namespace

/// Where the view ends in the sky there are gaps between the rings. So the estimate is taken from
/// the sectors with narrow spacing.
double ring_spacing(const PointCloud& cloud, const Eigen::Vector3d& p_base_sensor) {
  std::vector<double> found;
  for (const Sector& sector : observed_elevations(cloud, p_base_sensor)) {
    const double bins = bins_per_ring(sector);
    if (bins >= 0.0) found.push_back(bins);
  }
  if (found.size() < kLeastSectors) return 0.0;
  return quantile(std::move(found), 0.25) * kBin;
}

double RingSpacingGate::spacing_at(const Pose& T_map_sensor) const {
  const bool is_field =
      open_field_ && (T_map_sensor.translation - *open_field_).norm() <= kOpenFieldRadius;
  return is_field ? 0.0 : spacing_;
}

}  // namespace lidar_mapping::front_end
