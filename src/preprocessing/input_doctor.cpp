#include "lidar_mapping/preprocessing/input_doctor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <optional>

#include "lidar_mapping/preprocessing/interpolation.hpp"
#include "lidar_mapping/preprocessing/local_frame.hpp"

#include "time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kMostKept = 50000;  // samples of each input
constexpr double kGravity = 9.81;         // m/s^2
constexpr double kDegreesPerRadian = 180.0 / M_PI;
constexpr double kNoRadians = 12.0;          // rad/s; nobody maps while turning twice a second
constexpr double kSignificantOffset = 0.02;  // s
constexpr double kOutage = 3.0;              // s
constexpr double kShortOfPeriods = 3.5;      // periods without a scan

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char buffer[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

template <typename Sample>
void keep(std::vector<Sample>& samples, const Sample& sample) {
  if (samples.size() < kMostKept) samples.push_back(sample);
}

std::string stripped(const std::string& frame_id) {
  return !frame_id.empty() && frame_id[0] == '/' ? frame_id.substr(1) : frame_id;
}

/// Turning about the vertical of base_link, or about the sensor's where its place is not known.
template <typename Sample, typename Rate>
std::vector<TimedValue> turning(const std::vector<Sample>& samples, Rate Sample::*rate,
                                const std::optional<Pose>& T_base_sensor) {
  const Eigen::Quaterniond R =
      T_base_sensor ? T_base_sensor->rotation : Eigen::Quaterniond::Identity();
  std::vector<TimedValue> result;
  for (const Sample& sample : samples) result.push_back({sample.stamp, (R * (sample.*rate)).z()});
  return result;
}

/// Slope of the line through the origin that leads from x to y, at equal stamps (interpolated).
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
  if (!moves || xy * xy < 0.5 * xx * yy) return std::nullopt;  // not the same course
  return xy / xx;
}

void judge_offset(InputReport& report, const std::optional<TimeOffset>& offset,
                  const std::string& parameter) {
  if (!offset || std::abs(offset->seconds) < kSignificantOffset ||
      std::abs(offset->seconds) < 4.0 * offset->sigma || offset->sigma > 0.02) {
    return;
  }
  report.faults.push_back(
      text("its stamps are %.0f ms %s than those of the velocity for the same "
           "motion: set %s to %.3f",
           1e3 * std::abs(offset->seconds), offset->seconds > 0.0 ? "later" : "earlier",
           parameter.c_str(), -offset->seconds));
}

}  // namespace

void InputDoctor::Flow::see(Stamp stamp, const std::string& frame) {
  frame_id = frame;
  if (count++ == 0) {
    first = newest = stamp;
    return;
  }
  if (stamp <= newest) {
    ++backward;
    return;
  }
  if (stamp - newest > longest_gap) {
    longest_gap = stamp - newest;
    gap_begin = newest;
  }
  newest = stamp;
}

double InputDoctor::Flow::rate() const {
  const double seconds = to_seconds(newest - first);
  return seconds > 0.0 ? static_cast<double>(count - 1) / seconds : 0.0;
}

void InputDoctor::see_scan(const CloudSummary& cloud) {
  points_flow_.see(cloud.stamp, cloud.frame_id);
  if (cloud.points > 0) cloud_ = cloud;
}

void InputDoctor::see_imu(const ImuSample& sample, const std::string& frame_id) {
  imu_flow_.see(sample.stamp, frame_id);
  if (!is_plausible(sample)) return;
  sum_of_accelerations_ += sample.linear_acceleration;
  fastest_turn_ = std::max(fastest_turn_, sample.angular_velocity.norm());
  has_orientation_ = has_orientation_ || sample.orientation.has_value();
  keep(imu_, sample);
}

void InputDoctor::see_velocity(const VelocitySample& sample, const std::string& frame_id) {
  velocity_flow_.see(sample.stamp, frame_id);
  if (is_plausible(sample)) keep(velocity_, sample);
}

void InputDoctor::see_gnss(const GnssFix& fix, const std::string& frame_id) {
  gnss_flow_.see(fix.stamp, frame_id);
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) {
    ++bad_fixes_[problem.substr(0, problem.find(" of "))];
    return;
  }
  good_fix_flow_.see(fix.stamp, frame_id);
  covariance_known_ = covariance_known_ && fix.covariance.has_value();
  keep(fixes_, fix);
}

std::vector<InputReport> InputDoctor::report(const ExtrinsicLookup& lookup) const {
  return {points_report(lookup), imu_report(lookup), velocity_report(lookup), gnss_report(lookup)};
}

InputReport InputDoctor::begin(const std::string& input, const Flow& flow,
                               const ExtrinsicLookup& lookup) const {
  InputReport report{input, "nothing came", {}};
  if (flow.count == 0) return report;
  report.found = text("%.1f Hz, frame %s", flow.rate(),
                      flow.frame_id.empty() ? "(none)" : flow.frame_id.c_str());
  const std::string frame = stripped(flow.frame_id);
  if (frame.empty()) {
    report.faults.push_back("the messages name no frame: the driver must set header.frame_id");
  } else if (!lookup(frame)) {
    report.faults.push_back("no transform from '" + frame +
                            "' to base_link: publish it on /tf_static");
  }
  if (frame != flow.frame_id) {
    report.faults.push_back("frame '" + flow.frame_id +
                            "' has a leading slash, which tf2 refuses: it is left out here; mend "
                            "the driver");
  }
  if (flow.newest == 0) report.faults.push_back("the stamps are 0: the driver must stamp them");
  if (flow.backward > 0) {
    report.faults.push_back(
        text("%zu of %zu stamps do not increase: two publishers on one topic, or a recording that "
             "begins anew",
             flow.backward, flow.count));
  }
  return report;
}

InputReport InputDoctor::points_report(const ExtrinsicLookup& lookup) const {
  InputReport report = begin("points", points_flow_, lookup);
  if (points_flow_.count == 0) {
    report.faults.push_back("nothing came on the topic of the points: remap `points`");
    return report;
  }
  report.found += text(", fields %s, %zu points", cloud_.fields.c_str(), cloud_.points);
  judge_times(report);
  const double gap = to_seconds(points_flow_.longest_gap);
  if (gap > kShortOfPeriods / std::max(points_flow_.rate(), 1e-3)) {
    report.faults.push_back(text("%.1f s without a scan: scans were lost when recording", gap));
  }
  return report;
}

void InputDoctor::judge_times(InputReport& report) const {
  if (cloud_.time_field.empty()) {
    report.found += ", no point times";
    if (config_.point_times == PointTimes::kField) {
      report.faults.push_back(
          "the points have no times: right if the scans are motion-compensated; for raw ones set "
          "point_times to AZIMUTH");
    }
    return;
  }
  report.found += text(", times in `%s` (%s, %s) from %.4f to %.4f s", cloud_.time_field.c_str(),
                       cloud_.time_unit.c_str(), cloud_.absolute_times ? "absolute" : "relative",
                       cloud_.first_time, cloud_.last_time);
  const double span = cloud_.last_time - cloud_.first_time;
  if (span < 0.5 * config_.scan_period || span > 1.5 * config_.scan_period) {
    report.faults.push_back(
        text("its times span %.3g s, scan_period is %.3g s: mend scan_period "
             "or point_time_unit",
             span, config_.scan_period));
  }
  if (cloud_.foreign_clock) {
    report.faults.push_back(
        "its times are of another clock than its stamps: they are counted from the first point; "
        "synchronise the sensor (PTP, PPS)");
  }
}

InputReport InputDoctor::imu_report(const ExtrinsicLookup& lookup) const {
  InputReport report = begin("imu", imu_flow_, lookup);
  if (imu_.empty()) return report;
  const Eigen::Vector3d mean = sum_of_accelerations_ / static_cast<double>(imu_.size());
  const bool in_g = config_.imu_acceleration_unit == AccelerationUnit::kStandardGravity;
  const double gravity = mean.norm() * (in_g ? kGravity : 1.0);
  report.found += text(", gravity %.2f m/s2, turning up to %.2f rad/s, %s orientation", gravity,
                       fastest_turn_, has_orientation_ ? "with" : "without");
  const auto T_base_imu = lookup(stripped(imu_flow_.frame_id));
  if (gravity > 0.9 && gravity < 1.1) {
    report.faults.push_back("its accelerations are in g: set imu_acceleration_unit to G");
  } else if (gravity < 8.8 || gravity > 10.8) {
    report.faults.push_back(
        text("mean acceleration of %.2f m/s2 is not gravity: gravity was taken "
             "off, or the unit is another",
             gravity));
  } else if (T_base_imu && (T_base_imu->rotation * mean).z() < 0.0) {
    report.faults.push_back(
        "gravity has the wrong sign or the IMU is mounted upside down: an IMU at rest reports +g "
        "upward (REP 145); mend the driver or the transform");
  }
  const auto rates = turning(imu_, &ImuSample::angular_velocity, T_base_imu);
  const auto reference =
      turning(velocity_, &VelocitySample::angular, lookup(stripped(velocity_flow_.frame_id)));
  const auto scale = ratio(rates, reference);
  const bool degrees = (scale && *scale > 0.5 * kDegreesPerRadian) || fastest_turn_ > kNoRadians;
  if (degrees && config_.imu_angular_unit == AngularUnit::kRadians) {
    report.faults.push_back("its rates are in degrees/s: set imu_angular_unit to DEG_PER_S");
  } else if (scale && *scale < 0.0) {
    report.faults.push_back("it turns against the velocity's turning: mend the transform");
  } else {
    judge_offset(report, time_offset(reference, rates), "imu_time_offset");
  }
  return report;
}

InputReport InputDoctor::velocity_report(const ExtrinsicLookup& lookup) const {
  InputReport report = begin("velocity", velocity_flow_, lookup);
  if (velocity_.empty()) return report;
  const auto T_base_velocity = lookup(stripped(velocity_flow_.frame_id));
  double ahead = 0.0, aside = 0.0, fastest = 0.0;
  for (const VelocitySample& sample : velocity_) {
    const Eigen::Vector3d v =
        T_base_velocity ? in_base(sample, *T_base_velocity).linear : sample.linear;
    ahead += v.x() * v.x();
    aside += v.y() * v.y();
    fastest = std::max(fastest, v.norm());
  }
  report.found += text(", up to %.1f m/s", fastest);
  if (aside > 0.25 * ahead && fastest > 2.0) {
    report.faults.push_back(
        "it points aside as much as ahead: it is not in the axes of its frame (of the map "
        "instead?), or the transform is wrong");
  }
  return report;
}

InputReport InputDoctor::gnss_report(const ExtrinsicLookup& lookup) const {
  InputReport report = begin("gnss", gnss_flow_, lookup);
  if (gnss_flow_.count == 0) return report;
  report.found += text(", %zu of %zu fixes usable", good_fix_flow_.count, gnss_flow_.count);
  for (const auto& [problem, count] : bad_fixes_) {
    report.faults.push_back(text("%zu fixes refused: %s", count, problem.c_str()));
  }
  if (fixes_.empty()) return report;
  const double gap = to_seconds(good_fix_flow_.longest_gap);
  if (gap > kOutage) {
    report.faults.push_back(text("no usable fix for %.1f s, from %.1f s after the first on", gap,
                                 to_seconds(good_fix_flow_.gap_begin - good_fix_flow_.first)));
  }
  if (!covariance_known_) {
    report.faults.push_back(
        text("fixes without covariance: gnss_unknown_sigma_xy (%.1f m) stands in",
             config_.gnss_unknown_sigma_xy));
  }
  judge_jumps(report);
  judge_noise(report);
  return report;
}

/// Steps that the velocity (or anything that drives) does not explain.
void InputDoctor::judge_jumps(InputReport& report) const {
  LocalFrame frame(config_);
  std::vector<TimedValue> speeds, measured;
  for (const VelocitySample& sample : velocity_) {
    measured.push_back({sample.stamp, sample.linear.norm()});
  }
  std::optional<LocalFix> before;
  std::size_t jumps = 0;
  double largest = 0.0;
  for (const GnssFix& fix : fixes_) {
    const LocalFix now = frame.to_local(fix);
    if (before && now.stamp > before->stamp && to_seconds(now.stamp - before->stamp) < 1.5) {
      const double seconds = to_seconds(now.stamp - before->stamp);
      const double step = (now.p_enu - before->p_enu).norm();
      const double sigma = std::sqrt(now.covariance.trace() + before->covariance.trace());
      const Stamp middle = before->stamp + (now.stamp - before->stamp) / 2;
      const auto at = std::lower_bound(
          measured.begin(), measured.end(), middle,
          [](const TimedValue& value, Stamp stamp) { return value.stamp < stamp; });
      const double speed = at == measured.end() ? 70.0 : at->value;
      if (step > speed * seconds + 4.0 * sigma + 1.0) {
        ++jumps;
        largest = std::max(largest, step);
      } else {
        speeds.push_back({middle, step / seconds});
      }
    }
    before = now;
  }
  if (jumps > 0) {
    report.faults.push_back(
        text("%zu jumps of up to %.1f m: reflections or wrong ambiguities; "
             "keep gnss_gating on",
             jumps, largest));
  }
  judge_offset(report, time_offset(measured, speeds), "gnss_time_offset");
}

/// What changes from fix to fix faster than a vehicle can is noise; it must fit the covariance.
void InputDoctor::judge_noise(InputReport& report) const {
  LocalFrame frame(config_);
  std::vector<double> noise;
  double sigma = 0.0;
  std::vector<LocalFix> local;
  for (const GnssFix& fix : fixes_) local.push_back(frame.to_local(fix));
  for (std::size_t i = 2; i < local.size(); ++i) {
    if (to_seconds(local[i].stamp - local[i - 2].stamp) > 0.5) continue;
    const Eigen::Vector3d bend = local[i].p_enu - 2.0 * local[i - 1].p_enu + local[i - 2].p_enu;
    noise.push_back(bend.head<2>().norm() / std::sqrt(6.0));
    sigma += std::sqrt(local[i].covariance.topLeftCorner<2, 2>().trace());
  }
  if (noise.size() < 50 || !covariance_known_) return;
  sigma /= static_cast<double>(noise.size());
  std::nth_element(noise.begin(), noise.begin() + static_cast<long>(noise.size() / 2), noise.end());
  const double scatter = noise[noise.size() / 2] / 0.83;  // median to root mean square, two axes
  if (scatter > 3.0 * sigma) {
    report.faults.push_back(
        text("fixes scatter by %.2f m, their covariance says %.2f m: raise "
             "gnss_sigma_floor_xy",
             scatter, sigma));
  }
}

}  // namespace lidar_mapping::preprocessing
