// SPDX-License-Identifier: BSD-3-Clause
#include "scan/sweep_times.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {
namespace {

/// A cloud whose points turn by fewer rounds about the axis is stored firing by firing: one round,
/// or less if a part of the view is blocked. Chosen near 1, as a cloud that is stored ring by ring
/// has as many rounds as rings.
constexpr double kMaxRoundsOfFirings = 1.5;

/// In rounds: -0.5 to 0.5. A point on the axis has the azimuth 0.
double azimuth(const Point& point) {
  return static_cast<double>(std::atan2(point.y, point.x)) / (2.0 * kPi);
}

bool is_usable(const Point& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

/// How the azimuth advances from point to point.
struct Rotation {
  double first_azimuth = 0.0;
  double rounds = 0.0;  ///< from the first point to the last; positive: counterclockwise

  double direction() const { return rounds < 0.0 ? -1.0 : 1.0; }
  bool is_stored_by_firings() const { return std::abs(rounds) < kMaxRoundsOfFirings; }
};

Rotation rotation_of(const PointCloud& cloud) {
  Rotation rotation;
  std::optional<double> previous;
  for (const Point& point : cloud.points) {
    if (!is_usable(point)) continue;
    const double current = azimuth(point);
    if (!previous) rotation.first_azimuth = current;
    rotation.rounds += std::remainder(current - previous.value_or(current), 1.0);
    previous = current;
  }
  return rotation;
}

/// Fraction of the sweep before a point. The lasers of a firing point to different azimuths, so
/// that around the begin of the sweep only the position of a point in the cloud (0 to 1) tells
/// whether it belongs to the begin or to the end.
double fraction_of(const Point& point, double position, const Rotation& rotation) {
  if (!is_usable(point)) return position;
  const double rounds = rotation.direction() * (azimuth(point) - rotation.first_azimuth);
  const double whole =
      rotation.is_stored_by_firings() ? std::round(rounds - position) : std::floor(rounds);
  return rounds - whole;
}

/// Drivers send points in the order of their firings and stamp the begin of a sweep. Points in
/// another order went through a filter or a data set, and nothing tells what their stamp means: in
/// the middle it is off by half a sweep at most. KITTI's stamps are there.
std::vector<float> around_stamp(std::vector<float> times, double duration) {
  for (float& time : times) time -= static_cast<float>(0.5 * duration);
  return times;
}

/// The parameters of preprocessing that have the same effect.
std::string azimuth_parameters(const SweepTimesRule& rule) {
  if (!rule.rotation) return "point_times: AZIMUTH";
  return formatted(
      "point_times: AZIMUTH, scan_stamp: MIDDLE, scan_direction: %s, scan_start_azimuth_deg: %.0f, "
      "scan_period: %.3f",
      rule.rotation->clockwise ? "CLOCKWISE" : "COUNTERCLOCKWISE",
      rule.rotation->start_azimuth * kDegPerRad, rule.duration);
}

}  // namespace

std::vector<float> times_by_azimuth(const PointCloud& cloud, double duration) {
  const Rotation rotation = rotation_of(cloud);
  std::vector<float> times = times_by_position(cloud, 1.0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double position = static_cast<double>(times[i]);
    times[i] = static_cast<float>(duration * fraction_of(cloud.points[i], position, rotation));
  }
  return times;
}

std::vector<float> times_by_azimuth(const PointCloud& cloud, double duration,
                                    const SensorRotation& rotation) {
  const double start = rotation.start_azimuth / (2.0 * kPi);
  const double direction = rotation.clockwise ? -1.0 : 1.0;
  std::vector<float> times(cloud.size(), 0.0F);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_usable(cloud.points[i])) continue;
    const double rounds = direction * (azimuth(cloud.points[i]) - start);
    times[i] = static_cast<float>(duration * (rounds - std::floor(rounds)));
  }
  return times;
}

std::vector<float> times_by_position(const PointCloud& cloud, double duration) {
  std::vector<float> times(cloud.size());
  const double step = duration / static_cast<double>(std::max<std::size_t>(1, cloud.size()));
  for (std::size_t i = 0; i < times.size(); ++i)
    times[i] = static_cast<float>(step * static_cast<double>(i));
  return times;
}

std::vector<float> sweep_times(const PointCloud& cloud, const SweepTimesRule& rule) {
  switch (rule.source) {
    case SweepTimes::kAsGiven:
      break;
    case SweepTimes::kNegated: {
      std::vector<float> negated = cloud.times;
      for (float& time : negated) time = -time;
      return negated;
    }
    case SweepTimes::kByAzimuth:
      return rule.rotation ? around_stamp(times_by_azimuth(cloud, rule.duration, *rule.rotation),
                                          rule.duration)
                           : times_by_azimuth(cloud, rule.duration);
    case SweepTimes::kByPosition:
      return times_by_position(cloud, rule.duration);
  }
  return cloud.times;
}

PointCloud with_right_times(PointCloud cloud, const std::optional<UnevenTurning>& turning,
                            const PointCorrection& correction) {
  if (turning && correction.undo_gyro) cloud = put_back(*turning, std::move(cloud));
  if (correction.times.source != SweepTimes::kAsGiven)
    cloud.times = sweep_times(cloud, correction.times);
  return cloud;
}

const char* to_string(SweepTimes times) {
  switch (times) {
    case SweepTimes::kAsGiven:
      return "as_given";
    case SweepTimes::kNegated:
      return "negated";
    case SweepTimes::kByAzimuth:
      return "by_azimuth";
    case SweepTimes::kByPosition:
      return "by_position";
  }
  return "";
}

std::string sweep_times_message(const SweepTimesRule& rule) {
  switch (rule.source) {
    case SweepTimes::kAsGiven:
      return "";
    case SweepTimes::kNegated:
      return "points: their times run backwards, so the odometry negates them; correct the driver, "
             "because IMU and velocity still remove motion by the times as they are";
    case SweepTimes::kByAzimuth:
      return "points: they reach the odometry without times, and the motion within the sweep was "
             "not removed, or by a wrong velocity, so the odometry takes the times from the "
             "azimuth; record the times of the points, correct the velocity, or set " +
             azimuth_parameters(rule);
    case SweepTimes::kByPosition:
      return "points: they reach the odometry without times, and the motion within the sweep was "
             "not removed, or by a wrong velocity, so the odometry takes the times from the order "
             "of the points; record the times of the points, or correct the velocity";
  }
  return "";
}

}  // namespace lidar_mapping::front_end
