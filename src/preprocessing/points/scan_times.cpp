// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"

#include "points/times_kernel.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// Chosen: no spinning sensor turns slower than this, whatever scan_period is.
constexpr double kMaxScanDuration = 0.6;  // s
/// As a fraction of the period: the first column of a scan may be this much before its start.
/// Chosen: 7 degrees of a turn, about a packet of a driver.
constexpr double kSlack = 0.02;

std::string implausible(const TimeSpan& span, const PreprocessingConfig& config) {
  return formatted(
      "point times from %.6g to %.6g s do not fit a scan of %.3g s: the scan is taken "
      "without times; check point_time_unit and scan_period",
      span.begin, span.end, config.scan_period);
}

/// Offset between times relative to the scan's start and times relative to its stamp.
double start_to_stamp(const PreprocessingConfig& config) {
  if (config.scan_stamp == ScanStamp::kStart) return 0.0;
  return config.scan_stamp == ScanStamp::kMiddle ? 0.5 * config.scan_period : config.scan_period;
}

constexpr std::size_t kLanes = 4;  // floats in a register of 128 bits
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));

/// Computes lane by lane; comparisons with NaN are false.
class Extremes {
 public:
  Extremes(float first, float last) : first_(Floats{} + first), last_(Floats{} + last) {}

  void add(const float* times) {
    Floats time;
    std::memcpy(&time, times, sizeof(time));
    add_lanes(time);
  }
  void add(float time) { add_lanes(Floats{} + time); }

  float least() const {
    return std::min(std::min(first_[0], first_[1]), std::min(first_[2], first_[3]));
  }
  float greatest() const {
    return std::max(std::max(last_[0], last_[1]), std::max(last_[2], last_[3]));
  }

 private:
  void add_lanes(const Floats& time) {
    first_ = time < first_ ? time : first_;
    last_ = time > last_ ? time : last_;
  }

  Floats first_, last_;
};

}  // namespace

void TimeSpanFinder::add(const float* times, std::size_t count) {
  // Two independent chains hide the latency of a comparison.
  Extremes even{first_, last_}, odd{first_, last_};
  std::size_t i = 0;
  for (; i + 2 * kLanes <= count; i += 2 * kLanes) {
    even.add(times + i);
    odd.add(times + i + kLanes);
  }
  for (; i < count; ++i) even.add(times[i]);
  first_ = std::min(even.least(), odd.least());
  last_ = std::max(even.greatest(), odd.greatest());
}

TimeSpan TimeSpanFinder::span() const {
  if (first_ > last_) return {};
  return {first_, last_};
}

TimeSpan read_times(const unsigned char* first, std::size_t step, std::size_t count,
                    std::vector<float>& times) {
  Bounds bounds = {std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
  const TimesKernel read = times_kernel();
  fill_by_blocks(count, times, [&](std::size_t begin, std::size_t end) {
    bounds = read({first + begin * step, step, end - begin}, &times[begin], bounds);
  });
  if (bounds.least > bounds.greatest) return {};
  return {bounds.least, bounds.greatest};
}

TimeSpan time_span(const PointCloud& cloud) {
  TimeSpanFinder finder;
  finder.add(cloud.times.data(), cloud.times.size());
  return finder.span();
}

NormalizedTimes normalize_times(PointCloud& cloud, bool absolute, const PreprocessingConfig& config,
                                const std::optional<TimeSpan>& known) {
  if (config.point_times == PointTimes::kNone) cloud.times.clear();
  if (config.point_times == PointTimes::kAzimuth && !cloud.has_times()) {
    set_times_from_azimuth(cloud, config);
  }
  if (!cloud.has_times()) return {};
  const TimeSpan span = known ? *known : time_span(cloud);
  const double longest = std::max(1.5 * config.scan_period, kMaxScanDuration);
  if (span.end - span.begin > longest || span.end > longest || span.begin < -longest) {
    cloud.times.clear();
    return {{}, implausible(span, config)};
  }
  const bool from_start = !absolute && span.begin >= -kSlack * config.scan_period;
  const auto shift = static_cast<float>(start_to_stamp(config));
  if (!from_start || shift == 0.0F) return {span, ""};
  for (float& time : cloud.times) time -= shift;
  return {{span.begin - shift, span.end - shift}, ""};
}

}  // namespace lidar_mapping::preprocessing
