// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

#include "checks/input_checks.hpp"
#include "checks/velocity_check.hpp"
#include "motion/interpolation.hpp"
#include "motion/time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// Angular velocity about the vertical of base_link, or about the sensor's own z axis if its pose
/// is not known. `offset` (s) is added to the stamps, as preprocessing does.
template <typename Sample, typename Rate>
std::vector<TimedValue> turning(const std::vector<Sample>& samples, Rate Sample::*rate,
                                const std::optional<Pose>& T_base_sensor, double offset) {
  const Eigen::Quaterniond R =
      T_base_sensor ? T_base_sensor->rotation : Eigen::Quaterniond::Identity();
  const Stamp shift = from_seconds(offset);
  std::vector<TimedValue> result;
  for (const Sample& sample : samples) {
    result.push_back({sample.stamp + shift, (R * (sample.*rate)).z()});
  }
  return result;
}

/// Slope of the line through the origin that fits y over x, at equal stamps.
std::optional<double> ratio(const std::vector<TimedValue>& y, const std::vector<TimedValue>& x) {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  std::size_t i = 0;
  for (const TimedValue& value : y) {
    while (i + 1 < x.size() && x[i + 1].stamp < value.stamp) ++i;
    if (i + 1 >= x.size()) break;
    xx += x[i].value * x[i].value;
    xy += x[i].value * value.value;
    yy += value.value * value.value;
  }
  const bool moves = xx > 1e-3 * static_cast<double>(y.size());
  if (!moves || xy * xy < 0.5 * xx * yy) return std::nullopt;  // not the same signal
  return xy / xx;
}

Eigen::Vector3d mean_acceleration(const std::vector<ImuSample>& samples) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) sum += sample.linear_acceleration;
  return sum / static_cast<double>(samples.size());
}

double max_turn_rate(const std::vector<ImuSample>& samples) {
  double fastest = 0.0;
  for (const ImuSample& sample : samples) {
    fastest = std::max(fastest, sample.angular_velocity.norm());
  }
  return fastest;
}

/// `mean` is the mean acceleration as sent, `gravity` is its length in m/s^2.
void check_gravity(const Eigen::Vector3d& mean, double gravity,
                   const std::optional<Pose>& T_base_imu, InputReport& report) {
  if (gravity > 0.9 && gravity < 1.1) {
    add_fault(report, "its accelerations are in g", "set imu_acceleration_unit to G");
  } else if (gravity < 8.8 || gravity > 10.8) {
    add_fault(report, formatted("mean acceleration of %.2f m/s2 is not gravity", gravity),
              "gravity was removed, or the unit is wrong; correct the driver");
  } else if (T_base_imu && (T_base_imu->rotation * mean).z() < 0.0) {
    add_fault(report, "gravity has the wrong sign, or the IMU is mounted upside down",
              "an IMU at rest reports +g upward (REP 145); correct the driver or the transform");
  }
}

void check_rates(const ImuRecord& imu, const VelocityRecord& velocity,
                 const ExtrinsicLookup& lookup, const PreprocessingConfig& config,
                 InputReport& report) {
  const AngularUnit unit = config.imu_angular_unit;
  auto rates = turning(imu.samples, &ImuSample::angular_velocity, lookup(imu.topic.frame()),
                       config.imu_time_offset);
  for (TimedValue& rate : rates) rate.value *= si_factor(unit);
  const auto reference = turning(velocity.samples, &VelocitySample::angular,
                                 lookup(velocity.topic.frame()), config.velocity_time_offset);
  const auto scale = ratio(rates, reference);
  const bool degrees =
      (scale && *scale > 0.5 * kDegPerRad) || max_turn_rate(imu.samples) > kMaxVehicleTurnRate;
  if (degrees && unit == AngularUnit::kRadians) {
    add_fault(report, "its rates are in degrees/s", "set imu_angular_unit to DEG_PER_S");
  } else if (scale && *scale < 0.0) {
    add_fault(report, "it turns against the velocity's turning", "correct the transform");
  } else {
    check_offset(time_offset(reference, rates), "imu_time_offset", config.imu_time_offset, report);
  }
}

}  // namespace

void check_offset(const std::optional<TimeOffset>& offset, const std::string& parameter,
                  double configured, InputReport& report) {
  // s. Chosen: at 1 rad/s the ends of a scan are then off by 1 degree.
  constexpr double kSignificantOffset = 0.02;
  // s, standard deviation. Chosen: a smaller offset than kSignificantOffset would not be found.
  constexpr double kMaxSigma = 0.02;
  constexpr double kMinSigmas = 4.0;  // chosen: by chance once in 16,000 recordings
  if (!offset || offset->sigma > kMaxSigma) return;
  const double size = std::abs(offset->seconds);
  if (size < kSignificantOffset || size < kMinSigmas * offset->sigma) return;
  add_fault(report,
            formatted("its stamps are %.0f ms %s than those of the velocity for the same motion",
                      1e3 * size, offset->seconds > 0.0 ? "later" : "earlier"),
            formatted("set %s to %.3f", parameter.c_str(), configured - offset->seconds));
}

InputReport check(const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config) {
  InputReport report = check_headers("imu", imu.topic, lookup);
  if (imu.samples.empty()) return report;
  const bool has_acceleration =
      std::any_of(imu.samples.begin(), imu.samples.end(),
                  [](const ImuSample& sample) { return sample.has_linear_acceleration; });
  const Eigen::Vector3d mean = mean_acceleration(imu.samples);
  const double gravity = mean.norm() * si_factor(config.imu_acceleration_unit);
  const bool has_orientation =
      std::any_of(imu.samples.begin(), imu.samples.end(),
                  [](const ImuSample& sample) { return sample.orientation.has_value(); });
  report.found +=
      formatted(", gravity %.2f m/s2, turning up to %.2f rad/s, %s orientation", gravity,
                max_turn_rate(imu.samples) * si_factor(config.imu_angular_unit),
                has_orientation ? "with" : "without");
  if (has_acceleration) check_gravity(mean, gravity, lookup(imu.topic.frame()), report);
  check_rates(imu, velocity, lookup, config, report);
  return report;
}

InputReport check(const VelocityRecord& velocity, const GnssRecord& gnss,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config) {
  InputReport report = check_headers("velocity", velocity.topic, lookup);
  if (velocity.samples.empty()) return report;
  const auto T_base_velocity = lookup(velocity.topic.frame());
  double ahead = 0.0, sideways = 0.0, fastest = 0.0;
  for (const VelocitySample& sample : velocity.samples) {
    const Eigen::Vector3d v =
        T_base_velocity ? in_base(sample, *T_base_velocity).linear : sample.linear;
    ahead += v.x() * v.x();
    sideways += v.y() * v.y();
    fastest = std::max(fastest, v.norm());
  }
  report.found += formatted(", up to %.1f m/s", fastest);
  if (sideways > 0.25 * ahead && fastest > 2.0) {
    add_fault(report, "it points aside as much as ahead",
              "it is not in the axes of its frame (of the map instead?), or the transform is "
              "wrong; correct one of them");
  }
  const auto scale = speed_scale(velocity, gnss, config);
  if (scale && !is_true_scale(*scale)) {
    add_fault(report, scale_sentence(*scale),
              "publish m/s (REP 103), or set use_velocity to false");
  }
  return report;
}

}  // namespace lidar_mapping::preprocessing
