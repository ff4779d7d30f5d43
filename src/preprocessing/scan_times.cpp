#include "lidar_mapping/preprocessing/scan_times.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>

#include "lidar_mapping/preprocessing/scan_pass.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// No spinning sensor turns slower than this, whatever scan_period says.
constexpr double kLongestScan = 0.6;  // s
/// Relative to the period: the first column of a scan may be this much before its start.
constexpr double kSlack = 0.02;

std::string implausible(const TimeSpan& span, const PreprocessingConfig& config) {
  char text[240];
  std::snprintf(text, sizeof(text),
                "point times from %.6g to %.6g s do not fit a scan of %.3g s: the scan is taken "
                "without times; check point_time_unit and scan_period",
                span.begin, span.end, config.scan_period);
  return text;
}

/// How much earlier than the scan's start-based time a time based on its stamp is.
double start_to_stamp(const PreprocessingConfig& config) {
  switch (config.scan_stamp) {
    case ScanStamp::kStart:
      return 0.0;
    case ScanStamp::kMiddle:
      return 0.5 * config.scan_period;
    case ScanStamp::kEnd:
      return config.scan_period;
  }
  return 0.0;
}

}  // namespace

TimeSpan time_span(const PointCloud& cloud) {
  // Lanes of their own let the compiler use wide instructions; comparisons are false for NaN.
  constexpr std::size_t kLanes = 8;
  std::array<float, kLanes> begin;
  std::array<float, kLanes> end;
  begin.fill(std::numeric_limits<float>::max());
  end.fill(std::numeric_limits<float>::lowest());
  const float* const times = cloud.times.data();
  const std::size_t count = cloud.times.size();
  for (std::size_t i = 0; i + kLanes <= count; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float time = times[i + lane];
      begin[lane] = time < begin[lane] ? time : begin[lane];
      end[lane] = time > end[lane] ? time : end[lane];
    }
  }
  for (std::size_t i = count - count % kLanes; i < count; ++i) {
    begin[0] = times[i] < begin[0] ? times[i] : begin[0];
    end[0] = times[i] > end[0] ? times[i] : end[0];
  }
  const float first = *std::min_element(begin.begin(), begin.end());
  const float last = *std::max_element(end.begin(), end.end());
  if (first > last) return {};
  return {first, last};
}

SettledTimes settle_times(PointCloud& cloud, bool absolute, const PreprocessingConfig& config) {
  if (config.point_times == PointTimes::kNone) cloud.times.clear();
  if (config.point_times == PointTimes::kAzimuth && !cloud.has_times()) {
    set_times_from_azimuth(cloud, config);
  }
  if (!cloud.has_times()) return {};
  const TimeSpan span = time_span(cloud);
  const double longest = std::max(1.5 * config.scan_period, kLongestScan);
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
