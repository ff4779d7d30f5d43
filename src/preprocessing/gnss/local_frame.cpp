// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/local_frame.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// Largest usual acceleration and jerk of a vehicle in traffic. Chosen: the comfort limits of road
// and rail design are about as large.
constexpr double kAcceleration = 2.0;  // m/s^2
constexpr double kJerk = 2.0;          // m/s^3
/// Smallest distance in time between the first two of three fixes, as a fraction of that between
/// the last two. Chosen: otherwise their noise would be amplified.
constexpr double kMinStepRatio = 0.5;
constexpr double kMaxHeight = 12000.0;  // m; chosen above the altitude of airliners
constexpr double kMinHeight = -2000.0;  // m; chosen below all land

bool is_usable_covariance(const Eigen::Matrix3d& covariance) {
  return covariance.allFinite() && covariance.diagonal().minCoeff() >= 0.0 &&
         covariance.diagonal().head<2>().maxCoeff() > 0.0;
}

Eigen::Matrix3d diagonal(double sigma_xy, double sigma_z) {
  return Eigen::Vector3d(sigma_xy * sigma_xy, sigma_xy * sigma_xy, sigma_z * sigma_z).asDiagonal();
}

double altitude_of(const GnssFix& fix, double otherwise) {
  return std::isfinite(fix.altitude_m) ? fix.altitude_m : otherwise;
}

/// The reported covariance, made symmetric and not smaller than the lower bound; a configured one
/// if it is unknown.
Eigen::Matrix3d bounded_covariance(const GnssFix& fix, const PreprocessingConfig& config) {
  if (!fix.covariance || !is_usable_covariance(*fix.covariance)) {
    return diagonal(config.gnss_unknown_sigma_xy, config.gnss_unknown_sigma_z);
  }
  Eigen::Matrix3d covariance = 0.5 * (*fix.covariance + fix.covariance->transpose());
  const Eigen::Matrix3d floor = diagonal(config.gnss_sigma_floor_xy, config.gnss_sigma_floor_z);
  for (int i = 0; i < 3; ++i) covariance(i, i) = std::max(covariance(i, i), floor(i, i));
  const bool positive = Eigen::LLT<Eigen::Matrix3d>(covariance).info() == Eigen::Success;
  return positive ? covariance : Eigen::Matrix3d(covariance.diagonal().asDiagonal());
}

LocalFix on_chord(const LocalFix& a, const LocalFix& b, Stamp stamp) {
  const double f = to_seconds(stamp - a.stamp) / to_seconds(b.stamp - a.stamp);
  // The errors of neighbouring fixes are strongly correlated, so the mean is not more accurate than
  // its parts.
  LocalFix fix{stamp, a.p_enu + f * (b.p_enu - a.p_enu),
               (1.0 - f) * a.covariance + f * b.covariance};
  for (const LocalFix& end : {a, b}) {
    if (!has_height(end.covariance)) fix.covariance(2, 2) = end.covariance(2, 2);
  }
  return fix;
}

}  // namespace

double horizontal_sigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
}

std::string problem_of(const GnssFix& fix, const PreprocessingConfig& config) {
  if (fix.status < 0) return "the receiver has no fix";
  if (fix.status < config.gnss_min_status) return "status below gnss_min_status";
  // An altitude of NaN means that it is unknown, as in geographic_msgs/GeoPoint.
  if (!std::isfinite(fix.latitude_deg) || !std::isfinite(fix.longitude_deg) ||
      std::isinf(fix.altitude_m)) {
    return "coordinates are not finite";
  }
  if (fix.latitude_deg == 0.0 && fix.longitude_deg == 0.0) {
    return "coordinates (0, 0): the receiver has not begun";
  }
  if (std::abs(fix.latitude_deg) > 90.0 || std::abs(fix.longitude_deg) > 360.0) {
    return formatted("coordinates that are no degrees (latitude %.4f, longitude %.4f)",
                     fix.latitude_deg, fix.longitude_deg);
  }
  if (fix.altitude_m < kMinHeight || fix.altitude_m > kMaxHeight) {
    return formatted("height %.0f m is implausible (from %.0f to %.0f m)", fix.altitude_m,
                     kMinHeight, kMaxHeight);
  }
  if (fix.covariance && is_usable_covariance(*fix.covariance) &&
      horizontal_sigma(*fix.covariance) > config.gnss_max_sigma) {
    return formatted("standard deviation of %.1f m exceeds gnss_max_sigma (%.1f m)",
                     horizontal_sigma(*fix.covariance), config.gnss_max_sigma);
  }
  return "";
}

std::string kind_of_problem(const std::string& problem) {
  return problem.substr(0, problem.find_first_of("0123456789(:"));
}

Eigen::Vector3d step_between(const LocalFix& from, const LocalFix& to) {
  Eigen::Vector3d step = to.p_enu - from.p_enu;
  if (!has_height(from.covariance) || !has_height(to.covariance)) step.z() = 0.0;
  return step;
}

LocalFrame::LocalFrame(const PreprocessingConfig& config) : config_(config) {
  if (config.use_datum) set_datum({config.datum[0], config.datum[1], config.datum[2]});
}

void LocalFrame::set_datum(const GeodeticDatum& datum) {
  datum_ = datum;
  projection_.Reset(datum.latitude_deg, datum.longitude_deg, datum.altitude_m);
}

void LocalFrame::begin_at(const GnssFix& fix) {
  if (config_.use_datum) return;
  set_datum({fix.latitude_deg, fix.longitude_deg, altitude_of(fix, 0.0)});
}

LocalFix LocalFrame::to_local(const GnssFix& fix) {
  if (!datum_) begin_at(fix);
  Eigen::Matrix3d covariance = bounded_covariance(fix, config_);
  if (!std::isfinite(fix.altitude_m)) {
    covariance.row(2).setZero();
    covariance.col(2).setZero();
    covariance(2, 2) = kUnknownHeightStddev * kUnknownHeightStddev;
  }
  Eigen::Vector3d p;
  projection_.Forward(fix.latitude_deg, fix.longitude_deg, altitude_of(fix, datum_->altitude_m),
                      p.x(), p.y(), p.z());
  return {fix.stamp, p, covariance};
}

LocalFix interpolated(const LocalFix& a, const LocalFix& b, Stamp stamp) {
  if (a.stamp == b.stamp) return a;
  const double before = to_seconds(stamp - a.stamp);
  const double after = to_seconds(b.stamp - stamp);
  LocalFix result = on_chord(a, b, stamp);
  const double deviation = 0.5 * kAcceleration * before * after;
  result.covariance.diagonal().array() += deviation * deviation;
  return result;
}

LocalFix interpolated(const LocalFix& earlier, const LocalFix& a, const LocalFix& b, Stamp stamp) {
  const double step = to_seconds(a.stamp - earlier.stamp);
  const double next_step = to_seconds(b.stamp - a.stamp);
  if (step < kMinStepRatio * next_step || next_step <= 0.0) return interpolated(a, b, stamp);
  const Eigen::Vector3d half_acceleration =
      ((b.p_enu - a.p_enu) / next_step - (a.p_enu - earlier.p_enu) / step) / (step + next_step);
  const double before = to_seconds(stamp - a.stamp);
  const double after = to_seconds(b.stamp - stamp);
  LocalFix result = on_chord(a, b, stamp);
  result.p_enu -= before * after * half_acceleration;
  const double deviation = kJerk / 6.0 * before * after * (step + before);
  result.covariance.diagonal().array() += deviation * deviation;
  return result;
}

}  // namespace lidar_mapping::preprocessing
