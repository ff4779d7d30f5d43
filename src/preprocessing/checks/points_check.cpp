// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"

#include "checks/input_checks.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr double kMaxMissingPeriods = 3.5;  // without a scan; chosen: single losses do no harm
constexpr double kMaxTurnRate = 30.0;       // Hz; chosen: LiDARs turn at 5 to 20 Hz
constexpr double kMinDelay = 0.001;         // s; chosen: so soon no cloud has been delivered
/// Time from the stamp of a scan to its delivery, as a fraction of the scan's span. Chosen between:
/// a scan that was stamped at its start, in its middle or at its end is delivered after 1, 0.5 or 0
/// at the earliest.
constexpr double kMaxDelayOfMiddle = 0.8;
constexpr double kMaxDelayOfEnd = 0.4;

/// True if the span is about one turn.
bool is_one_turn(double span, double period) {
  return span >= 0.5 * period && span <= 1.5 * period;
}

/// True if a sensor that sees a part of its turn, as others do of their view, turns as configured.
bool is_part_of_turn(double span, double rate, double period) {
  constexpr double kLeastPart = 0.1;      // of a turn, 36 degrees; chosen: the narrowest usual view
  constexpr double kMaxDifference = 0.2;  // of the periods; chosen: some scans may be lost
  return span >= kLeastPart * period && span <= period &&
         std::abs(1.0 / rate - period) < kMaxDifference * period;
}

/// The span is one turn if it agrees with the parameter or with the time from scan to scan. A cloud
/// that spans less is right for a sensor that sees a part of its turn. Packets always hold the
/// whole turn, so that of those a part was lost.
void check_span(const CloudSummary& cloud, double rate, const PreprocessingConfig& config,
                InputReport& report) {
  const double span = cloud.last_time - cloud.first_time;
  if (is_one_turn(span, config.scan_period)) return;
  const bool holds_packets = !cloud.contents.empty();
  if (!holds_packets && rate > 0.0 && is_part_of_turn(span, rate, config.scan_period)) return;
  const std::string problem =
      formatted("the points' times span %.3g s, scan_period is %.3g s", span, config.scan_period);
  if (rate <= 0.0 || !is_one_turn(span, 1.0 / rate)) {
    add_fault(report, problem, "correct scan_period or point_time_unit");
  } else if (config.scan_stamp != ScanStamp::kStart) {
    add_fault(report, problem, "set scan_period, from which scan_stamp counts");
  }
}

/// Whether the times count from the stamp in some scans only.
bool is_mixed(const PointsRecord& points) {
  return points.of_other_clock > 0 && points.of_other_clock < points.timed;
}

void check_times(const PointsRecord& points, const PreprocessingConfig& config,
                 InputReport& report) {
  const CloudSummary& cloud = points.cloud;
  if (cloud.time_field.empty()) {
    report.found += ", no point times";
    if (config.point_times == PointTimes::kField) {
      add_warning(report, "the points have no times",
                  "right if the scans are motion-compensated; for raw ones set point_times to "
                  "AZIMUTH");
    }
    return;
  }
  report.found +=
      formatted(", times in `%s` (%s, %s) from %.4f to %.4f s", cloud.time_field.c_str(),
                cloud.time_unit.c_str(), cloud.absolute_times ? "absolute" : "relative",
                cloud.first_time, cloud.last_time);
  if (is_mixed(points)) {
    add_fault(
        report,
        formatted("the points' times count from the stamp in %zu scans and from elsewhere in "
                  "%zu, as a clock that begins anew every second",
                  points.timed - points.of_other_clock, points.of_other_clock),
        "correct the driver, or set point_times to NONE: the odometry then finds the times of "
        "a sensor that turns");
    return;
  }
  check_span(cloud, points.topic.rate(), config, report);
  if (cloud.foreign_clock) {
    add_warning(report, "the points' times are of another clock than the stamps",
                "they are counted from the first point; synchronise the sensor (PTP, PPS)");
  }
}

/// A cloud cannot be delivered before its last point was measured. If the delivery is too early for
/// a stamp at the start, the stamp was set later. Recordings whose stamps are the times of delivery
/// cannot be checked.
void check_stamps(const PointsRecord& points, const PreprocessingConfig& config,
                  InputReport& report) {
  const CloudSummary& cloud = points.cloud;
  const double span = cloud.last_time - cloud.first_time;
  const bool from_start = !cloud.time_field.empty() && !cloud.absolute_times &&
                          cloud.first_time > -0.1 * span && config.scan_stamp == ScanStamp::kStart;
  if (!from_start || points.topic.delays.empty()) return;
  const double delay = median(points.topic.delays);
  if (delay < kMinDelay || delay > kMaxDelayOfMiddle * span) return;
  add_warning(
      report,
      formatted("clouds came %.0f ms after their stamps, with points of up to %.0f ms after them",
                1e3 * delay, 1e3 * cloud.last_time),
      formatted("set scan_stamp to %s; or the sensor's clock is ahead, synchronise it",
                delay < kMaxDelayOfEnd * span ? "END" : "MIDDLE"));
}

/// A cloud that is a part of a turn is no scan.
void check_rate(const PointsRecord& points, InputReport& report) {
  if (points.topic.rate() <= kMaxTurnRate) return;
  add_fault(report,
            formatted("%.0f clouds a second of %zu points are parts of turns", points.topic.rate(),
                      points.cloud.points),
            "have the driver publish whole turns, or ten clouds a second of a sensor that does "
            "not turn");
}

/// The fields, the number and the times of the points, if at least one cloud was not empty.
void check_content(const PointsRecord& points, const PreprocessingConfig& config,
                   InputReport& report) {
  const CloudSummary& cloud = points.cloud;
  if (cloud.points == 0) return;
  report.found += cloud.contents.empty() ? ", fields " + cloud.fields : ", " + cloud.contents;
  report.found += formatted(", %zu points", cloud.points);
  check_times(points, config, report);
  check_rate(points, report);
}

/// Where the points lie around the sensor, and where the sensor is on the vehicle.
void check_positions(const PointsRecord& points, const ExtrinsicLookup& lookup,
                     InputReport& report) {
  if (!points.cloud.extent) return;
  check_extent(*points.cloud.extent, report);
  check_place(points.topic.frame(), lookup, report);
}

/// Where the end of a turn meets its beginning, the points tell which times are right.
void check_seam(const PointsRecord& points, const PreprocessingConfig& config,
                InputReport& report) {
  if (config.point_times == PointTimes::kNone) return;
  if (points.seam.is_reversed()) {
    add_fault(report, "the points' times run backwards",
              "correct the driver, or set point_times to NONE");
  }
  if (points.seam.is_compensated() && !is_mixed(points)) {
    add_fault(report, "the motion during the scans was taken out before, but the points have times",
              "they would be deskewed twice: set point_times to NONE");
  }
}

/// Scans without points, damaged packets, and times without a scan.
void check_losses(const PointsRecord& points, InputReport& report) {
  if (points.empty > 0) {
    add_fault(report,
              formatted("%zu of %zu scans have no points", points.empty, points.topic.count),
              "the sensor saw nothing or was not ready: record again, or cut them off");
  }
  if (points.damaged_packets > 0) {
    add_warning(report, formatted("%zu packets of the sensor are damaged", points.damaged_packets),
                "they are left out; look at the network between sensor and computer");
  }
  const double gap = to_seconds(points.topic.longest_gap);
  if (gap > kMaxMissingPeriods / std::max(points.topic.rate(), 1e-3)) {
    add_warning(report, formatted("%.1f s without a scan", gap),
                "scans were lost when recording: record with a larger buffer (rosbag record -b)");
  }
}

}  // namespace

InputReport check(const PointsRecord& points, const ExtrinsicLookup& lookup,
                  const PreprocessingConfig& config) {
  InputReport report = check_headers("points", points.topic, lookup);
  if (points.topic.count == 0) {
    add_fault(report, "nothing came on the topic of the points", "remap `points`");
    return report;
  }
  check_content(points, config, report);
  check_stamps(points, config, report);
  check_positions(points, lookup, report);
  check_seam(points, config, report);
  check_losses(points, report);
  return report;
}

}  // namespace lidar_mapping::preprocessing
