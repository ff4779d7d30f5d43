#include <algorithm>
#include <cmath>
#include <optional>

#include "lidar_mapping/preprocessing/local_frame.hpp"

#include "examinations.hpp"
#include "time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kOutage = 3.0;              // s
constexpr double kFastest = 70.0;            // m/s
constexpr double kLongestStep = 1.5;         // s between fixes that are compared
constexpr double kSignificantOffset = 0.02;  // s

std::vector<LocalFix> local_fixes(const GnssRecord& gnss, const PreprocessingConfig& config) {
  LocalFrame frame(config);
  std::vector<LocalFix> fixes;
  for (const GnssFix& fix : gnss.good.samples) fixes.push_back(frame.to_local(fix));
  return fixes;
}

double value_at(const std::vector<TimedValue>& values, Stamp stamp, double otherwise) {
  const auto at =
      std::lower_bound(values.begin(), values.end(), stamp,
                       [](const TimedValue& value, Stamp other) { return value.stamp < other; });
  return at == values.end() ? otherwise : at->value;
}

/// Steps from fix to fix: those that something drove, as speeds, and the jumps.
struct Steps {
  std::vector<TimedValue> speeds;
  std::size_t jumps = 0;
  double largest_jump = 0.0;
};

Steps steps_of(const std::vector<LocalFix>& fixes, const std::vector<TimedValue>& measured) {
  Steps steps;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const LocalFix& before = fixes[i - 1];
    const LocalFix& now = fixes[i];
    const double seconds = to_seconds(now.stamp - before.stamp);
    if (seconds <= 0.0 || seconds > kLongestStep) continue;
    const double step = (now.p_enu - before.p_enu).norm();
    const double sigma = std::sqrt(now.covariance.trace() + before.covariance.trace());
    const Stamp middle = before.stamp + (now.stamp - before.stamp) / 2;
    if (step > value_at(measured, middle, kFastest) * seconds + 4.0 * sigma + 1.0) {
      ++steps.jumps;
      steps.largest_jump = std::max(steps.largest_jump, step);
    } else {
      steps.speeds.push_back({middle, step / seconds});
    }
  }
  return steps;
}

void judge_offset(const std::optional<TimeOffset>& offset, InputReport& report) {
  if (!offset || std::abs(offset->seconds) < kSignificantOffset ||
      std::abs(offset->seconds) < 4.0 * offset->sigma || offset->sigma > 0.02) {
    return;
  }
  add_fault(report,
            text("its stamps are %.0f ms %s than those of the velocity for the same motion",
                 1e3 * std::abs(offset->seconds), offset->seconds > 0.0 ? "later" : "earlier"),
            text("set gnss_time_offset to %.3f", -offset->seconds));
}

/// Steps that the velocity (or anything that drives) does not explain.
void judge_steps(const std::vector<LocalFix>& fixes, const VelocityRecord& velocity,
                 InputReport& report) {
  std::vector<TimedValue> measured;
  for (const VelocitySample& sample : velocity.samples) {
    measured.push_back({sample.stamp, sample.linear.norm()});
  }
  const Steps steps = steps_of(fixes, measured);
  if (steps.jumps > 0) {
    add_warning(report, text("%zu jumps of up to %.1f m", steps.jumps, steps.largest_jump),
                "reflections or wrong ambiguities; keep gnss_gating on");
  }
  judge_offset(time_offset(measured, steps.speeds), report);
}

/// What changes from fix to fix faster than a vehicle can is noise; it must fit the covariance.
void judge_noise(const std::vector<LocalFix>& fixes, InputReport& report) {
  std::vector<double> noise;
  double sigma = 0.0;
  for (std::size_t i = 2; i < fixes.size(); ++i) {
    if (to_seconds(fixes[i].stamp - fixes[i - 2].stamp) > 0.5) continue;
    const Eigen::Vector3d bend = fixes[i].p_enu - 2.0 * fixes[i - 1].p_enu + fixes[i - 2].p_enu;
    noise.push_back(bend.head<2>().norm() / std::sqrt(6.0));
    sigma += std::sqrt(fixes[i].covariance.topLeftCorner<2, 2>().trace());
  }
  if (noise.size() < 50) return;
  sigma /= static_cast<double>(noise.size());
  std::nth_element(noise.begin(), noise.begin() + static_cast<long>(noise.size() / 2), noise.end());
  const double scatter = noise[noise.size() / 2] / 0.83;  // median to root mean square, two axes
  if (scatter > 3.0 * sigma) {
    add_fault(report, text("fixes scatter by %.2f m, their covariance says %.2f m", scatter, sigma),
              text("raise gnss_sigma_floor_xy to %.1f", std::ceil(scatter * 10.0) / 10.0));
  }
}

}  // namespace

InputReport examine(const GnssRecord& gnss, const VelocityRecord& velocity,
                    const ExtrinsicLookup& lookup, const PreprocessingConfig& config) {
  InputReport report = examine_headers("gnss", gnss.flow, lookup);
  if (gnss.flow.count == 0) return report;
  const TopicFlow& good = gnss.good.flow;
  report.found += text(", %zu of %zu fixes usable", good.count, gnss.flow.count);
  for (const auto& [problem, count] : gnss.refused) {
    add_warning(report, text("%zu fixes refused: %s", count, problem.c_str()),
                "they are left out; the map leans on odometry and loops there");
  }
  if (gnss.good.samples.empty()) return report;
  const double gap = to_seconds(good.longest_gap);
  if (gap > kOutage) {
    add_warning(report,
                text("no usable fix for %.1f s, from %.1f s after the first on", gap,
                     to_seconds(good.gap_begin - good.first)),
                "expect drift there unless loops close over it");
  }
  if (!gnss.covariance_known) {
    add_warning(report, "fixes without covariance",
                text("gnss_unknown_sigma_xy (%.1f m) stands in", config.gnss_unknown_sigma_xy));
  }
  const std::vector<LocalFix> fixes = local_fixes(gnss, config);
  judge_steps(fixes, velocity, report);
  if (gnss.covariance_known) judge_noise(fixes, report);
  return report;
}

}  // namespace lidar_mapping::preprocessing
