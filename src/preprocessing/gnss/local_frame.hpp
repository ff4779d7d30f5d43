// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <GeographicLib/LocalCartesian.hpp>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/common/unknown_height.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// A position of the antenna in the local frame.
struct LocalFix {
  Stamp stamp = 0;
  Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();  ///< m, East-North-Up
  /// m^2, not smaller than the configured lower bound; see has_height()
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

/// m/s: largest speed between fixes where none was measured. Chosen: faster than any car on a road
/// (250 km/h).
constexpr double kMaxRoadSpeed = 70.0;

/// The larger standard deviation of East and North, m.
double horizontal_sigma(const Eigen::Matrix3d& covariance);

/// The problem of a fix by itself: no fix, not finite, not on the Earth, (0, 0), status or
/// covariance too poor. Empty for a usable fix.
std::string problem_of(const GnssFix& fix, const PreprocessingConfig& config);
/// The problem up to its first figure: the same text for all fixes with the same kind of problem.
std::string kind_of_problem(const std::string& problem);

/// The way from one fix to another, m; level if the height of one of them is not known.
Eigen::Vector3d step_between(const LocalFix& from, const LocalFix& to);

/// Converts geodetic coordinates to the East-North-Up tangent plane at a datum, by
/// GeographicLib::LocalCartesian (exact on the ellipsoid). The datum is the configured one, or else
/// the first fix. A fix without altitude is taken at the height of the datum, with
/// kUnknownHeightStddev; as the first one it puts the datum on the ellipsoid (height 0).
class LocalFrame {
 public:
  explicit LocalFrame(const PreprocessingConfig& config);

  /// The fix in the local frame, with a covariance that is not smaller than the lower bound. The
  /// fix must be usable.
  LocalFix to_local(const GnssFix& fix);
  /// Sets the datum to this fix, unless the datum is configured. Positions that were converted
  /// before have to be converted again.
  void begin_at(const GnssFix& fix);
  std::optional<GeodeticDatum> datum() const { return datum_; }

 private:
  void set_datum(const GeodeticDatum& datum);

  PreprocessingConfig config_;
  std::optional<GeodeticDatum> datum_;
  GeographicLib::LocalCartesian projection_;  ///< at the datum, once there is one
};

/// The position at `stamp`, interpolated between two fixes. Its covariance is the weighted mean of
/// theirs, plus the largest deviation of a vehicle from the straight line between them (half the
/// acceleration of 2 m/s^2 times both distances in time).
LocalFix interpolated(const LocalFix& a, const LocalFix& b, Stamp stamp);

/// The same on the parabola through these two fixes and the previous one: in a bend the straight
/// line lies inside, at 1 Hz and 3 m/s^2 by up to 0.4 m. The covariance is increased by the error
/// of the parabola (Newton) for a jerk of 2 m/s^3.
LocalFix interpolated(const LocalFix& earlier, const LocalFix& a, const LocalFix& b, Stamp stamp);

}  // namespace lidar_mapping::preprocessing
