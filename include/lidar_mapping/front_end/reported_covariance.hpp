#pragma once

#include "lidar_mapping/registration/ndt_matcher.hpp"

namespace lidar_mapping::front_end {

/// Covariance of a match (pose and twist) as it is reported. The filter weighs the points low,
/// because neighbouring ones err together, and so holds itself for worse than it is. What is
/// reported has the size of the errors of simulated drives.
registration::Matrix12d reported_covariance(const registration::NdtMatch& match);

/// The same in a map of few scans.
registration::Matrix12d covariance_in_young_map(const registration::NdtMatch& match);

}  // namespace lidar_mapping::front_end
