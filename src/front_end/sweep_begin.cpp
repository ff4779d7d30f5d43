// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_begin.hpp"

#include <cmath>

namespace lidar_mapping::front_end {
namespace {

/// Weight of one of the poses at the begin, for its rotation and its translation.
struct Weight {
  double rotation;
  double translation;
};
// Three poses at the begin: the current sweep continued backwards, the previous one continued
// forwards, and the pose between the middles on the motion that joins them, all with the steady
// acceleration. For exact matches of a motion with constant jerk each has the weight 1/3. Matches
// are not exact: twists are noisier than poses, that of the translation most. These weights lessen
// the errors of steps in 19 drives of all carriers by a quarter (rotation) and a tenth
// (translation); doc/results/front_end.md.
constexpr Weight kForwards{0.15, -0.1};
constexpr Weight kBetween{0.25, 0.5};

/// Sweeps whose middles are farther apart than this number of sweep durations do not touch.
constexpr double kMaxDistance = 1.3;
/// Distance between stamp and begin, as a fraction of the duration, up to which they are the same.
constexpr double kStampTolerance = 0.1;

void add(const Weight& weight, const Vector6d& offset, Vector6d& sum) {
  sum.head<3>() += weight.translation * offset.head<3>();
  sum.tail<3>() += weight.rotation * offset.tail<3>();
}

/// From the middle of the previous sweep to the begin of the current one.
double seconds_to_begin(const SweepPair& sweeps, double duration) {
  return sweeps.seconds - 0.5 * duration;
}

Pose continued_forwards(const SweepPair& sweeps, const Vector6d& acceleration, double duration) {
  return steadily_accelerated(sweeps.previous, acceleration, duration,
                              seconds_to_begin(sweeps, duration))
      .T_map_sensor;
}

/// On the chord between two points of a parabola. Both are matches, which lie beside the parabola
/// as steadily_accelerated() tells.
Pose between_middles(const SweepPair& sweeps, const Vector6d& acceleration, double duration) {
  const Pose& start = sweeps.previous.T_map_sensor;
  const double to_begin = seconds_to_begin(sweeps, duration);
  const Vector6d mean_twist = twist_between(start, sweeps.current.T_map_sensor, sweeps.seconds);
  const double bend = 0.5 * to_begin * (sweeps.seconds - to_begin) + duration * duration / 24.0;
  return moved(moved(start, mean_twist, to_begin), acceleration, -bend);
}

}  // namespace

SweepMotion improved_begin(const SweepMotion& motion, const SweepPair& sweeps, double duration,
                           bool rotation) {
  const Pose& begin = motion.begin.T_map_sensor;
  Vector6d shift = Vector6d::Zero();
  add(kForwards, difference(begin, continued_forwards(sweeps, motion.acceleration, duration)),
      shift);
  add(kBetween, difference(begin, between_middles(sweeps, motion.acceleration, duration)), shift);
  if (!rotation) shift.tail<3>().setZero();
  // Parabolas over the sweep. That of the translation is 1 at the begin and 0 at middle and end,
  // that of the rotation is 1 at both ends and 0 at the middle.
  SweepMotion improved = motion;
  improved.begin.T_map_sensor = perturbed(begin, shift);
  improved.begin.twist.head<3>() -= 3.0 / duration * shift.head<3>();
  improved.acceleration.head<3>() += 4.0 / (duration * duration) * shift.head<3>();
  improved.begin.twist.tail<3>() -= 4.0 / duration * shift.tail<3>();
  improved.acceleration.tail<3>() += 8.0 / (duration * duration) * shift.tail<3>();
  return improved;
}

SweepMotion motion_from_stamp(const MotionFilter& filter, double duration, double to_stamp) {
  const SweepMotion motion{
      steadily_accelerated(filter.state(), filter.acceleration(), duration, to_stamp),
      filter.acceleration()};
  const std::optional<PreviousMatch>& previous = filter.previous_match();
  if (!previous || previous->seconds_before > kMaxDistance * duration ||
      std::abs(to_stamp + 0.5 * duration) > kStampTolerance * duration) {
    return motion;
  }
  return improved_begin(motion, {previous->state, filter.state(), previous->seconds_before},
                        duration, !filter.is_rotation_measured());
}

}  // namespace lidar_mapping::front_end
