// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/text.hpp"

#include "checks/input_checks.hpp"
#include "gnss/gnss_track.hpp"
#include "gnss/local_frame.hpp"
#include "motion/motion_sensors.hpp"
#include "motion/time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s without a fix that are reported. Chosen: shorter ones are bridged by odometry within a few
// centimetres (1 % of the path).
constexpr double kMinOutage = 3.0;
// s between fixes that are compared. Chosen: the slowest usual rate is 1 Hz, and a lost fix is an
// outage.
constexpr double kMaxStepDuration = 1.5;
// s: the delay is known below this standard deviation. Chosen: 0.3 m at 15 m/s.
constexpr double kMaxOffsetSigma = 0.02;
constexpr double kPriorArmSigma = 3.0;  // m, standard deviation; chosen: half of a vehicle's length
// m: smaller errors of the antenna's place cost less than the noise of most receivers. Chosen.
constexpr double kMinArmError = 0.4;
constexpr double kSigmas = 5.0;  // chosen: a false alarm sends a person to the vehicle to measure
// Interval over which the speeds of fixes are computed. Chosen: longer ones cut bends short,
// shorter ones hold more noise.
constexpr Stamp kSectionDuration = from_seconds(2.0);
// m in that interval. Chosen: below walking pace (2 m/s) the noise of the fixes decides.
constexpr double kMinSectionLength = 4.0;
// Length of the interval in multiples of the scatter. Chosen: the speed is then good to about a
// fifth.
constexpr double kMinScatterRatio = 8.0;
constexpr std::size_t kMinSections = 10;  // for a median; chosen
// Multiple of the sigma in the messages. Chosen: receivers are often wrong by a factor of two.
constexpr double kMaxSigmaRatio = 3.0;
// m/s^2. Chosen as of traffic; it also bends the path between fixes.
constexpr double kUsualAcceleration = 1.0;

/// With stamps that are moved by `gnss_time_offset`, as preprocessing does.
std::vector<LocalFix> local_fixes(const GnssRecord& gnss, const PreprocessingConfig& config) {
  LocalFrame frame(config);
  std::vector<LocalFix> fixes;
  for (const GnssFix& fix : gnss.usable.samples) {
    fixes.push_back(frame.to_local(fix));
    fixes.back().stamp += from_seconds(config.gnss_time_offset);
  }
  return fixes;
}

/// The first value at or after a stamp.
double value_from(const std::vector<TimedValue>& values, Stamp stamp, double otherwise) {
  const auto at = first_not_before(values, stamp);
  return at == values.end() ? otherwise : at->value;
}

/// Steps from fix to fix: those that a vehicle can make, as speeds, and the jumps.
struct Steps {
  std::vector<TimedValue> speeds;
  std::size_t jumps = 0;
  double largest_jump = 0.0;
};

/// `scatter` is the measured noise of the fixes, m.
Steps steps_of(const std::vector<LocalFix>& fixes, const std::vector<TimedValue>& measured,
               double scatter) {
  Steps steps;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const LocalFix& before = fixes[i - 1];
    const LocalFix& now = fixes[i];
    const double seconds = to_seconds(now.stamp - before.stamp);
    if (seconds <= 0.0 || seconds > kMaxStepDuration) continue;
    const double step = step_between(before, now).norm();
    const auto variance = [&](const LocalFix& fix) {
      const bool is_level = !has_height(before.covariance) || !has_height(now.covariance);
      return is_level ? fix.covariance.topLeftCorner<2, 2>().trace() : fix.covariance.trace();
    };
    const double stated = std::sqrt(variance(now) + variance(before));
    const double sigma = std::max(stated, 2.0 * scatter);
    const Stamp middle = before.stamp + (now.stamp - before.stamp) / 2;
    if (step > value_from(measured, middle, kMaxRoadSpeed) * seconds + 4.0 * sigma + 1.0) {
      ++steps.jumps;
      steps.largest_jump = std::max(steps.largest_jump, step);
    } else {
      steps.speeds.push_back({middle, step / seconds});
    }
  }
  return steps;
}

/// With stamps that are moved by `velocity_time_offset`, as preprocessing does.
std::vector<TimedValue> speeds_of(const VelocityRecord& velocity,
                                  const PreprocessingConfig& config) {
  const Stamp shift = from_seconds(config.velocity_time_offset);
  std::vector<TimedValue> speeds;
  for (const VelocitySample& sample : velocity.samples) {
    speeds.push_back({sample.stamp + shift, sample.linear.norm()});
  }
  return speeds;
}

/// Processes the fixes as preprocessing does.
void replay(const GnssRecord& gnss, const ImuRecord& imu, const VelocityRecord& velocity,
            const Extrinsics& extrinsics, const PreprocessingConfig& config, GnssTrack& track) {
  MotionSensors sensors(config, extrinsics);
  const auto add_until = [](Stamp stamp, const auto& record, std::size_t& next, const auto& add) {
    for (; next < record.samples.size() && record.samples[next].stamp <= stamp; ++next) {
      add(record.samples[next], record.topic.frame());
    }
  };
  std::size_t next_imu = 0, next_velocity = 0;
  const Stamp latency = from_seconds(config.max_latency);
  for (const GnssFix& fix : gnss.usable.samples) {
    add_until(fix.stamp + latency, imu, next_imu,
              [&](const auto& sample, const auto& frame) { sensors.add_imu(sample, frame); });
    add_until(fix.stamp + latency, velocity, next_velocity,
              [&](const auto& sample, const auto& frame) { sensors.add_velocity(sample, frame); });
    track.add(fix, gnss.topic.frame());
    track.evaluate_pending(sensors, {fix.stamp, latency}, Waiting::kEnds);
  }
}

/// The horizontal standard deviation that the messages themselves state, without the lower bound,
/// m: the median of the roots of the sum of both axes' variances, as in FixScatter.
double stated_sigma(const std::vector<GnssFix>& fixes) {
  std::vector<double> sigmas;
  for (const GnssFix& fix : fixes) {
    if (fix.covariance) sigmas.push_back(std::sqrt(fix.covariance->topLeftCorner<2, 2>().trace()));
  }
  return sigmas.empty() ? 0.0 : median(std::move(sigmas));
}

void check_scatter(const FixScatter& scatter, const GnssRecord& gnss,
                   const PreprocessingConfig& config, InputReport& report) {
  if (!scatter.is_known()) return;
  const double stated_by_messages = stated_sigma(gnss.usable.samples);
  const double acceleration_scatter = kUsualAcceleration / std::pow(gnss.usable.topic.rate(), 2);
  if (scatter.measured() < kMaxSigmaRatio * stated_by_messages + acceleration_scatter) return;
  const bool is_covered = scatter.variance_factor() <= 1.0;
  const double of_an_axis = scatter.measured() / std::sqrt(2.0);
  add_warning(report,
              formatted("fixes scatter by %.2f m, but their covariance gives %.3f m",
                        scatter.measured(), stated_by_messages),
              is_covered ? formatted("gnss_sigma_floor_xy (%.2f m) is used instead",
                                     config.gnss_sigma_floor_xy)
                         : formatted("the covariance is raised to the measured scatter; set "
                                     "gnss_sigma_floor_xy to %.1f to raise it from the beginning",
                                     std::ceil(of_an_axis * 10.0) / 10.0));
}

/// False if too little is known of the antenna to check the stamps, which were moved by
/// `configured` (s).
bool check_antenna(const AntennaFit& fit, const Eigen::Vector3d& p_base_antenna, double configured,
                   InputReport& report) {
  const AntennaFit::Result result = fit.result(kPriorArmSigma);
  if (result.delay_sigma > kMaxOffsetSigma) return false;
  check_offset(TimeOffset{result.delay, result.delay_sigma}, "gnss_time_offset", configured,
               report);
  const double off = result.arm_error.norm();
  if (off > std::max(kMinArmError, kSigmas * result.arm_sigma)) {
    const Eigen::Vector2d arm = p_base_antenna.head<2>() + result.arm_error;
    add_fault(report,
              formatted("the fixes move like those of an antenna at (%.1f, %.1f) m in base_link, "
                        "but tf gives (%.1f, %.1f)",
                        arm.x(), arm.y(), p_base_antenna.x(), p_base_antenna.y()),
              "correct the transform of the frame of GNSS");
  }
  return true;
}

/// Counts the fixes that are used, and those that are refused.
void check_usable(const GnssRecord& gnss, InputReport& report) {
  report.found += formatted(", %zu of %zu fixes usable", gnss.usable.topic.count, gnss.topic.count);
  for (const auto& [kind, fixes] : gnss.refused) {
    add_warning(report, formatted("%zu fixes refused: %s", fixes.count, fixes.problem.c_str()),
                "they are not used; there the map depends on odometry and loops alone");
  }
}

void check_outages(const TopicStatistics& usable, InputReport& report) {
  const double gap = to_seconds(usable.longest_gap);
  if (gap <= kMinOutage) return;
  add_warning(report,
              formatted("no usable fix for %.1f s, from %.1f s after the first on", gap,
                        to_seconds(usable.gap_begin - usable.first)),
              "expect drift there unless loops correct it");
}

void check_jumps(const Steps& steps, InputReport& report) {
  if (steps.jumps == 0) return;
  add_warning(report, formatted("%zu jumps of up to %.1f m", steps.jumps, steps.largest_jump),
              "reflections or wrong ambiguities; keep gnss_gating on");
}

}  // namespace

std::optional<double> speed_scale(const VelocityRecord& velocity, const GnssRecord& gnss,
                                  const PreprocessingConfig& config) {
  const std::vector<LocalFix> fixes = local_fixes(gnss, config);
  FixScatter scatter;
  for (const LocalFix& fix : fixes) scatter.add(fix);
  const double min_length = kMinScatterRatio * (scatter.is_known() ? scatter.measured() : 0.0);
  const std::vector<TimedValue> measured = speeds_of(velocity, config);
  std::vector<double> scales;
  std::size_t from = 0;
  for (const LocalFix& fix : fixes) {
    while (fix.stamp - fixes[from].stamp > kSectionDuration) ++from;
    const double seconds = to_seconds(fix.stamp - fixes[from].stamp);
    const double section_length = (fix.p_enu - fixes[from].p_enu).head<2>().norm();
    const Stamp middle = fix.stamp - (fix.stamp - fixes[from].stamp) / 2;
    const double speed = value_from(measured, middle, 0.0);
    if (section_length > std::max(kMinSectionLength, min_length) && speed > 0.0)
      scales.push_back(speed * seconds / section_length);
  }
  if (scales.size() < kMinSections) return std::nullopt;
  return median(std::move(scales));
}

InputReport check(const GnssRecord& gnss, const ImuRecord& imu, const VelocityRecord& velocity,
                  const ExtrinsicLookup& lookup, const PreprocessingConfig& config) {
  InputReport report = check_headers("gnss", gnss.topic, lookup);
  if (gnss.topic.count == 0) return report;
  check_usable(gnss, report);
  if (gnss.usable.samples.empty()) return report;
  check_outages(gnss.usable.topic, report);
  if (!gnss.covariance_known) {
    add_warning(
        report, "fixes without covariance",
        formatted("gnss_unknown_sigma_xy (%.1f m) is used instead", config.gnss_unknown_sigma_xy));
  }
  const Extrinsics extrinsics(lookup);
  GnssTrack track(config, extrinsics);
  replay(gnss, imu, velocity, extrinsics, config, track);
  const FixScatter& scatter = track.scatter();
  if (gnss.covariance_known) check_scatter(scatter, gnss, config, report);
  const std::vector<TimedValue> speeds = speeds_of(velocity, config);
  const Steps steps =
      steps_of(local_fixes(gnss, config), speeds, scatter.is_known() ? scatter.measured() : 0.0);
  check_jumps(steps, report);
  const double offset = config.gnss_time_offset;
  const auto T_base_antenna = extrinsics.T_base(gnss.topic.frame());
  if (!T_base_antenna ||
      !check_antenna(track.antenna_fit(), T_base_antenna->translation, offset, report)) {
    check_offset(time_offset(speeds, steps.speeds), "gnss_time_offset", offset, report);
  }
  return report;
}

}  // namespace lidar_mapping::preprocessing
