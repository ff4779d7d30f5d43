// SPDX-License-Identifier: BSD-3-Clause
#include "motion/carrier_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/units.hpp"

#include "motion/smoothing.hpp"
#include "scenarios/scenario.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr double kStep = Track::kStep;  ///< s

/// Steps slower than this push less, m/s. Chosen: half of the speed of a slow walk.
constexpr double kFirmStep = 0.6;

/// Accelerations of the body: x unused, y left, z up, then yaw, pitch and roll.
using Pushes = std::vector<Vector6d>;

void add_push(Pushes& pushes, std::size_t first, double seconds, const Vector6d& peak) {
  const auto count = static_cast<std::size_t>(std::lround(seconds / kStep));
  for (std::size_t k = 0; k <= count && first + k < pushes.size(); ++k) {
    pushes[first + k] += std::sin(kPi * static_cast<double>(k) / static_cast<double>(count)) * peak;
  }
}

/// Pushes at all footfalls.
Pushes footfalls(const std::vector<TrackState>& states, const Carrier& carrier, Random& random) {
  Pushes pushes(states.size(), Vector6d::Zero());
  int step = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (states[i].distance < (step + 1) * carrier.step_length) continue;
    const double side = ++step % 2 == 0 ? 1.0 : -1.0;
    const double speed = (states[i].distance - states[i - 1].distance) / kStep;
    const double firmness = std::min(1.0, speed / kFirmStep);
    const auto about = [&](double peak) { return firmness * peak * random.uniform(0.75, 1.25); };
    Vector6d peak = Vector6d::Zero();
    peak(1) = side * about(carrier.side_push);
    peak(2) = about(carrier.push);
    peak(3) = side * about(carrier.tilt_push);
    peak(4) = about(carrier.tilt_push);
    peak(5) = -side * about(carrier.tilt_push);
    add_push(pushes, i, carrier.push_s, peak);
  }
  return pushes;
}

/// Displacements of a mass on a damped spring, which starts at rest.
std::vector<Vector6d> springs(const Pushes& pushes, double hz, double damping) {
  const double omega = 2.0 * kPi * hz;
  std::vector<Vector6d> offsets(pushes.size());
  Vector6d offset = Vector6d::Zero(), rate = Vector6d::Zero();
  for (std::size_t i = 0; i < pushes.size(); ++i) {
    rate += kStep * (pushes[i] - 2.0 * damping * omega * rate - omega * omega * offset);
    offset += kStep * rate;
    offsets[i] = offset;
  }
  return offsets;
}

/// Slow movements of hands or of a body about an axis.
class Sway {
 public:
  Sway(double amplitude, Random& random) : amplitude_(amplitude) {
    for (double& phase : phases_) phase = random.uniform(0.0, 2.0 * kPi);
  }
  double at(double seconds) const {
    constexpr std::array<double, 3> kHz = {0.13, 0.29, 0.61};
    double sum = 0.0;
    for (std::size_t i = 0; i < kHz.size(); ++i) {
      sum += std::sin(2.0 * kPi * kHz[i] * seconds + phases_[i]) - std::sin(phases_[i]);
    }
    return amplitude_ * sum / 1.7;
  }

 private:
  double amplitude_;
  std::array<double, 3> phases_{};
};

/// x, y, z, yaw, pitch and roll of the ground under the body.
std::vector<Vector6d> body_on_ground(const std::vector<TrackState>& states,
                                     const std::vector<Ground>& ground, bool tilts) {
  std::vector<Vector6d> body(states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Eigen::Vector2d ahead(std::cos(states[i].yaw), std::sin(states[i].yaw));
    const Eigen::Vector2d left(-ahead.y(), ahead.x());
    const double pitch = tilts ? -std::atan(ground[i].gradient.dot(ahead)) : 0.0;
    const double roll = tilts ? std::atan(ground[i].gradient.dot(left)) : 0.0;
    body[i] << states[i].position, ground[i].height, states[i].yaw, pitch, roll;
  }
  return smoothed(std::move(body), static_cast<int>(std::lround(0.08 / kStep)), 3);
}

}  // namespace

Carrier running_carrier() {
  Carrier carrier;
  carrier.step_length = 1.1;
  carrier.push = 14.0;
  carrier.push_s = 0.12;
  carrier.side_push = 4.0;
  carrier.tilt_push = 12.0;
  carrier.spring_hz = 1.6;
  carrier.damping = 0.35;
  return carrier;
}

Carrier legged_carrier() {
  Carrier carrier;
  carrier.height = 0.5;
  carrier.arm = 0.0;
  carrier.step_length = 0.32;
  carrier.push = 36.5;  // 3 g after the springs have taken their part
  carrier.push_s = 0.025;
  carrier.side_push = 8.0;
  carrier.tilt_push = 60.0;
  carrier.spring_hz = 4.0;
  carrier.damping = 0.3;
  carrier.sway = 0.015;
  carrier.tilts_with_ground = true;
  carrier.mounting = legged_mounting();
  return carrier;
}

SmoothTrajectory carried_trajectory(const Track& track, const std::vector<Ground>& ground,
                                    const Carrier& carrier, Random random) {
  const std::vector<TrackState>& states = track.states();
  const std::vector<Vector6d> body = body_on_ground(states, ground, carrier.tilts_with_ground);
  const std::vector<Vector6d> bounce =
      springs(footfalls(states, carrier, random), carrier.spring_hz, carrier.damping);
  const std::array<Sway, 3> sway = {Sway(carrier.sway, random), Sway(carrier.sway, random),
                                    Sway(carrier.sway, random)};
  std::vector<Vector6d> control(states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    Vector6d& c = control[i] = body[i];
    c.tail<3>() += bounce[i].tail<3>();
    for (int k = 0; k < 3; ++k) c(3 + k) += sway[k].at(static_cast<double>(i) * kStep);
    const Eigen::Vector2d ahead(std::cos(c(3)), std::sin(c(3)));
    c.head<2>() += carrier.arm * ahead + bounce[i](1) * Eigen::Vector2d(-ahead.y(), ahead.x());
    c(2) += carrier.height + bounce[i](2);
  }
  return SmoothTrajectory(kDriveBegin, kStep, std::move(control));
}

}  // namespace lidar_mapping::simulation
