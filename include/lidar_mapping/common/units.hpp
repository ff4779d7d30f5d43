// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping {

/// Half a turn, rad, by definition.
constexpr double kPi = 3.14159265358979323846;
/// The same in single precision, rad.
constexpr auto kPiFloat = static_cast<float>(kPi);
/// Factor from degrees to radians, by definition. Angles are radians everywhere but in files,
/// parameters and reports for people.
constexpr double kRadPerDeg = kPi / 180.0;
/// Factor from radians to degrees, by definition.
constexpr double kDegPerRad = 180.0 / kPi;

/// m/s^2: the standard acceleration of gravity (3rd CGPM, 1901). Its true value differs from it by
/// less than 0.3 % anywhere on Earth.
constexpr double kStandardGravity = 9.80665;

}  // namespace lidar_mapping
