// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// A position of the antenna in the local frame.
struct LocalFix {
  Stamp stamp = 0;
  Eigen::Vector3d p_enu = Eigen::Vector3d::Zero();           ///< m, East-North-Up
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, never below the floor
  int status = 0;
};

/// What is wrong with a fix by itself: no fix, not finite, off the earth, (0, 0), status or
/// covariance too poor. Empty for a usable one.
std::string problem_of(const GnssFix& fix, const PreprocessingConfig& config);

/// Geodetic coordinates to the East-North-Up tangent plane at a datum, by
/// GeographicLib::LocalCartesian (exact on the ellipsoid). The datum is the configured one, or the
/// first fix that comes.
class LocalFrame {
 public:
  explicit LocalFrame(const PreprocessingConfig& config);
  ~LocalFrame();

  /// The fix in the local frame, with a covariance that is at least the floor. The fix is usable.
  LocalFix to_local(const GnssFix& fix);
  /// The datum becomes that fix, unless it is configured. What is local already is to be made anew.
  void begin_at(const GnssFix& fix);
  std::optional<GeodeticDatum> datum() const;

 private:
  class Projection;
  PreprocessingConfig config_;
  std::unique_ptr<Projection> projection_;
};

/// The position at `stamp` between two fixes. Its covariance is that of the weighted mean plus what
/// a vehicle may turn aside from the straight line between them (half the acceleration of 2 m/s^2
/// times both distances in time).
LocalFix interpolated(const LocalFix& a, const LocalFix& b, Stamp stamp);

/// The same on the parabola through these two and the fix before: in a bend the chord lies inside,
/// at 1 Hz and 3 m/s^2 by up to 0.4 m. What is added to the covariance is the error of that
/// (Newton) with a jerk of 2 m/s^3.
LocalFix interpolated(const LocalFix& earlier, const LocalFix& a, const LocalFix& b, Stamp stamp);

}  // namespace lidar_mapping::preprocessing
