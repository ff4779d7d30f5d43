#include "lidar_mapping/front_end/reported_covariance.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace lidar_mapping::front_end {

using registration::Matrix12d;
using registration::NdtMatch;

namespace {

/// Weight of the points in the covariance that is reported, in units of their weight in the filter.
constexpr double kReportedWeight = 24.0;

// A map of few scans of a sensor with few rings has planes that lean, and all points that meet one
// err together: the fewer of them find a plane, the worse. Measured on simulated drives.
constexpr double kYoungOverlap = 0.75;  // share of points with a plane that is enough
constexpr double kLeastOverlap = 0.45;
constexpr double kYoungPower = 8.0;

double variance_of_young_map(double overlap) {
  return std::pow(kYoungOverlap / std::clamp(overlap, kLeastOverlap, kYoungOverlap), kYoungPower);
}

}  // namespace

Matrix12d reported_covariance(const NdtMatch& match) {
  const Matrix12d information =
      match.information + (kReportedWeight - 1.0) * match.points_information;
  return information.inverse();
}

Matrix12d covariance_in_young_map(const NdtMatch& match) {
  return variance_of_young_map(match.overlap) * reported_covariance(match);
}

}  // namespace lidar_mapping::front_end
