// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/scan_pass.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "lidar_mapping/common/units.hpp"

#include "points/move_kernel.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// m. Points without an echo lie at the sensor's origin. Chosen: no LiDAR measures a range of a
/// centimetre.
constexpr float kMinRange = 0.01F;

/// Time slots per step of 2 ms of the motion. Chosen: within 1 ms and at 1 rad/s, the middle of a
/// bend lies 1e-7 rad (0.01 mm at 100 m) beside a straight line.
constexpr int kSlotsPerStep = 2;

using Matrix34 = Eigen::Matrix<double, 3, 4>;

void write(const Matrix34& place, float* to) {
  Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>{to} = place.cast<float>();
}

std::vector<MotionSlot> identity_slots() {
  std::vector<MotionSlot> slots(1);
  write(Matrix34::Identity(), slots.front().transform);
  return slots;
}

/// The linear motion between two poses with a small rotation between them.
MotionSlot slot_between(const Matrix34& begin, const Matrix34& end) {
  const Matrix34 middle = 0.5 * (begin + end);
  const Matrix34 change = end - begin;
  const Eigen::Matrix3d W = change.leftCols<3>() * middle.leftCols<3>().transpose();
  const Eigen::Vector3d turning(0.5 * (W(2, 1) - W(1, 2)), 0.5 * (W(0, 2) - W(2, 0)),
                                0.5 * (W(1, 0) - W(0, 1)));
  MotionSlot slot;
  write(middle, slot.transform);
  Eigen::Map<Eigen::Vector3f>{slot.turning} = turning.cast<float>();
  Eigen::Map<Eigen::Vector3f>{slot.drift} =
      (change.col(3) - turning.cross(middle.col(3))).cast<float>();
  return slot;
}

Matrix34 matrix_of(const Pose& pose) {
  Matrix34 matrix;
  matrix << pose.rotation_matrix(), pose.translation;
  return matrix;
}

/// interpolate(a, b, 0.5) without its arc cosine: the normalised mean of two quaternions lies
/// halfway.
Pose halfway(const Pose& a, const Pose& b) {
  const double sign = a.rotation.dot(b.rotation) < 0.0 ? -1.0 : 1.0;
  Pose middle;
  middle.rotation.coeffs() = (a.rotation.coeffs() + sign * b.rotation.coeffs()).normalized();
  middle.translation = 0.5 * (a.translation + b.translation);
  return middle;
}

/// The motion of the sensor itself, in its own axes.
std::vector<MotionSlot> slots_of(const ScanMotion& motion,
                                 const Eigen::Quaterniond& R_base_sensor) {
  std::vector<MotionSlot> slots;
  slots.reserve(kSlotsPerStep * (motion.T_stamp_knot.size() - 1));
  const Pose R{R_base_sensor, Eigen::Vector3d::Zero()};
  const auto sensor_motion = [&](const Pose& T_stamp_base) {
    return matrix_of(R.inverse() * T_stamp_base * R);
  };
  Matrix34 begin = sensor_motion(motion.T_stamp_knot.front());
  for (std::size_t knot = 1; knot < motion.T_stamp_knot.size(); ++knot) {
    const Pose& T_stamp_knot = motion.T_stamp_knot[knot];
    const Matrix34 middle = sensor_motion(halfway(motion.T_stamp_knot[knot - 1], T_stamp_knot));
    const Matrix34 end = sensor_motion(T_stamp_knot);
    slots.push_back(slot_between(begin, middle));
    slots.push_back(slot_between(middle, end));
    begin = end;
  }
  return slots;
}

KeepRule keep_rule(const PassLimits& limits, const Pose& T_base_sensor) {
  KeepRule rule{};
  rule.near_squared = limits.near_squared;
  rule.far_squared = limits.far_squared;
  rule.has_box = (limits.box_max - limits.box_min).minCoeff() > 0.0F;
  Eigen::Map<Eigen::Vector3f>{rule.box_min} = limits.box_min;
  Eigen::Map<Eigen::Vector3f>{rule.box_max} = limits.box_max;
  write(matrix_of(T_base_sensor), rule.to_box);
  return rule;
}

}  // namespace

PassLimits::PassLimits(const PreprocessingConfig& config)
    : box_min(Eigen::Map<const Eigen::Vector3d>(&config.vehicle_box[0]).cast<float>()),
      box_max(Eigen::Map<const Eigen::Vector3d>(&config.vehicle_box[3]).cast<float>()) {
  const bool cut = config.use_distance_filter;
  const float near = cut ? static_cast<float>(config.distance_near_thresh) : 0.0F;
  near_squared = std::max(near, kMinRange) * std::max(near, kMinRange);
  const auto far = static_cast<float>(config.distance_far_thresh);
  far_squared = cut ? far * far : std::numeric_limits<float>::max();
}

PackedPoints packed_in(const PointCloud& cloud) {
  return {nullptr, reinterpret_cast<const unsigned char*>(cloud.points.data()), sizeof(Point),
          offsetof(Point, intensity)};
}

std::size_t keep_and_deskew(const PackedPoints& packed, PointCloud& cloud,
                            const Pose& T_base_sensor, const PassLimits& limits,
                            const ScanMotion* motion, PointTimesAfter times) {
  if (cloud.empty()) return 0;
  const std::vector<MotionSlot> slots =
      motion == nullptr ? identity_slots() : slots_of(*motion, T_base_sensor.rotation);
  SlottedMotion slotted{slots.data(), static_cast<int>(slots.size()), 0.0F, 0.0F};
  if (motion != nullptr) {
    slotted.begin = static_cast<float>(motion->begin);
    slotted.slots_per_second = static_cast<float>(kSlotsPerStep / motion->step);
  }
  const bool keeps_times = cloud.has_times() && times == PointTimesAfter::kKept;
  static_assert(sizeof(Point) == 4 * sizeof(float));
  const PointSource source{packed.first, packed.step, packed.intensity,
                           cloud.has_times() ? cloud.times.data() : nullptr, cloud.size()};
  const MoveResult result = move_kernel()(source, {&cloud.points.data()->x, cloud.times.data()},
                                          keep_rule(limits, T_base_sensor), slotted, keeps_times);
  cloud.points.resize(result.kept);
  cloud.times.resize(keeps_times ? result.kept : 0);
  return result.not_finite;
}

void set_times_from_azimuth(PointCloud& cloud, const PreprocessingConfig& config) {
  const double sign = config.scan_direction == ScanDirection::kClockwise ? -1.0 : 1.0;
  const auto turns_per_radian = static_cast<float>(sign / (2.0 * kPi));
  const auto start = static_cast<float>(sign * config.scan_start_azimuth / (2.0 * kPi));
  const auto period = static_cast<float>(config.scan_period);
  cloud.times.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    const float turns = std::atan2(p.y, p.x) * turns_per_radian - start;
    cloud.times[i] = period * (turns - std::floor(turns));
  }
}

}  // namespace lidar_mapping::preprocessing
