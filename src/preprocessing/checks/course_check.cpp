// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/units.hpp"

#include "checks/input_checks.hpp"
#include "gnss/local_frame.hpp"
#include "motion/time_offset.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// m of a section of the path. Chosen: its course is then good to a tenth of a radian with fixes
// that scatter by 0.3 m.
constexpr double kSectionLength = 5.0;
// s for a section, and from one to the next. Chosen: a vehicle that needs longer hardly moves.
constexpr double kMaxDuration = 5.0;
constexpr double kMaxImuGap = 0.1;  // s that are integrated; chosen as a few samples
// Sum of squares, rad^2: a bend of 90 degrees in five sections. Chosen: with less the noise of the
// courses could decide.
constexpr double kMinSquaredTurning = 0.5;
// Of the turning by the fixes and by the gyro, -1 for a mirror image. Chosen: half of the squares.
constexpr double kMaxCorrelation = -0.7;

/// The course over ground in the middle of each section, rad from East to the left.
std::vector<TimedValue> courses_of(const GnssRecord& gnss, const PreprocessingConfig& config) {
  LocalFrame frame(config);
  std::vector<TimedValue> courses;
  std::optional<LocalFix> from;
  for (const GnssFix& fix : gnss.usable.samples) {
    const LocalFix to = frame.to_local(fix);
    if (!from || to_seconds(to.stamp - from->stamp) > kMaxDuration) from = to;
    const Eigen::Vector2d step = (to.p_enu - from->p_enu).head<2>();
    if (step.norm() < kSectionLength) continue;
    courses.push_back({from->stamp + (to.stamp - from->stamp) / 2, std::atan2(step.y(), step.x())});
    from = to;
  }
  return courses;
}

/// The angle about the vertical since the first sample by the gyro, rad.
std::vector<TimedValue> headings_of(const ImuRecord& imu, const Eigen::Quaterniond& R_base_imu,
                                    const PreprocessingConfig& config) {
  const double unit = si_factor(config.imu_angular_unit);
  std::vector<TimedValue> headings;
  double angle = 0.0;
  for (const ImuSample& sample : imu.samples) {
    const double gap = headings.empty() ? 0.0 : to_seconds(sample.stamp - headings.back().stamp);
    if (gap < 0.0) continue;
    angle += unit * (R_base_imu * sample.angular_velocity).z() * std::min(gap, kMaxImuGap);
    headings.push_back({sample.stamp, angle});
  }
  return headings;
}

/// The first value at or after a stamp, which is not later than the last one.
double value_at(const std::vector<TimedValue>& values, Stamp stamp) {
  return first_not_before(values, stamp)->value;
}

}  // namespace

bool fixes_are_mirrored(const GnssRecord& gnss, const ImuRecord& imu, const ExtrinsicLookup& lookup,
                        const PreprocessingConfig& config) {
  const auto T_base_imu = lookup(imu.topic.frame());
  if (!T_base_imu || imu.samples.empty()) return false;
  const std::vector<TimedValue> courses = courses_of(gnss, config);
  const std::vector<TimedValue> headings = headings_of(imu, T_base_imu->rotation, config);
  double gg = 0.0, ga = 0.0, aa = 0.0;
  for (std::size_t i = 1; i < courses.size(); ++i) {
    const TimedValue& before = courses[i - 1];
    const TimedValue& now = courses[i];
    const bool is_known = before.stamp >= headings.front().stamp &&
                          now.stamp <= headings.back().stamp &&
                          to_seconds(now.stamp - before.stamp) <= kMaxDuration;
    if (!is_known) continue;
    const double a = std::remainder(now.value - before.value, 2.0 * kPi);
    const double g = value_at(headings, now.stamp) - value_at(headings, before.stamp);
    gg += g * g;
    ga += g * a;
    aa += a * a;
  }
  return aa > kMinSquaredTurning && ga < kMaxCorrelation * std::sqrt(gg * aa);
}

}  // namespace lidar_mapping::preprocessing
