// SPDX-License-Identifier: BSD-3-Clause
#include "sensors/samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <GeographicLib/LocalCartesian.hpp>

#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

namespace lidar_mapping::simulation {

namespace {

constexpr Stamp kVelocityPeriod = 10'000'000;  ///< ns
/// Of a jump of GNSS, s; chosen as of a reflection at a halt.
constexpr double kJumpDuration = 10.0;

Eigen::Vector3d normal3(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

enum Stream : std::uint64_t { kGyroStream = 1, kAccelerometerStream };

/// A gyroscope or an accelerometer with three axes. All random values except bias and noise of the
/// samples come from a separate stream, so that the noise of the samples does not depend on them.
class InertialSensor {
 public:
  InertialSensor(const InertialErrors& errors, Stamp period, Random& noise, Random own)
      : errors_(errors),
        noise_(errors.noise + errors.noise_density / std::sqrt(to_seconds(period))),
        step_(errors.bias_walk * std::sqrt(to_seconds(period))),
        bias_(normal3(noise, errors.bias)),
        distortion_(Eigen::Matrix3d::Identity()),
        own_(own) {
    distortion_.diagonal() += normal3(own_, errors.scale);
    const Eigen::Vector3d turned = normal3(own_, errors.misalignment);
    if (errors.misalignment > 0.0) distortion_ = exp_so3(turned).toRotationMatrix() * distortion_;
  }

  Eigen::Vector3d measured(const Eigen::Vector3d& truth, Random& noise) {
    const Eigen::Vector3d value = distortion_ * truth + bias_ + normal3(noise, noise_);
    bias_ += normal3(own_, step_);
    return value.cwiseMax(-errors_.range).cwiseMin(errors_.range);
  }

 private:
  InertialErrors errors_;
  double noise_;
  double step_;
  Eigen::Vector3d bias_;
  Eigen::Matrix3d distortion_;
  Random own_;
};

bool lies_in(const std::vector<GnssOutage>& outages, double seconds) {
  return std::any_of(outages.begin(), outages.end(), [&](const GnssOutage& outage) {
    return seconds >= outage.begin_s && seconds < outage.end_s;
  });
}

Eigen::Vector3d jump_offset(const std::vector<GnssJump>& jumps, double seconds) {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  for (const GnssJump& jump : jumps) {
    if (seconds < jump.at_s || seconds >= jump.at_s + kJumpDuration) continue;
    offset += jump.metres * Eigen::Vector3d(M_SQRT1_2, M_SQRT1_2, 0.0);
  }
  return offset;
}

GnssFix without_fix(Stamp stamp) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  return {stamp, kNothing, kNothing, kNothing, -1, {}};
}

}  // namespace

std::vector<ImuSample> sample_imu(const SmoothTrajectory& trajectory, const Pose& T_base_imu,
                                  const ImuModel& model, Stamp period, std::uint64_t seed) {
  Random random(seed);
  InertialSensor gyro(model.gyro, period, random, Random(seed, kGyroStream));
  InertialSensor accelerometer(model.accelerometer, period, random,
                               Random(seed, kAccelerometerStream));
  std::vector<ImuSample> samples;
  for (Stamp stamp = trajectory.begin(); stamp <= trajectory.end(); stamp += period) {
    const MotionState state = trajectory.state(stamp).of_frame(T_base_imu);
    const Eigen::Quaterniond& R_map_imu = state.T_map_base.rotation;
    const Eigen::Vector3d force =
        R_map_imu.conjugate() * (state.acceleration_map + Eigen::Vector3d(0.0, 0.0, kGravity));
    ImuSample sample;
    sample.stamp = stamp;
    sample.angular_velocity = gyro.measured(state.angular_velocity_base, random);
    sample.linear_acceleration = accelerometer.measured(force, random);
    if (model.orientation_noise) {
      sample.orientation =
          (R_map_imu * exp_so3(normal3(random, *model.orientation_noise))).normalized();
    }
    samples.push_back(sample);
  }
  return samples;
}

std::vector<VelocitySample> sample_velocity(const SmoothTrajectory& trajectory,
                                            const Pose& T_base_imu, std::uint64_t seed) {
  Random random(seed);
  std::vector<VelocitySample> samples;
  for (Stamp stamp = trajectory.begin(); stamp <= trajectory.end(); stamp += kVelocityPeriod) {
    const MotionState state = trajectory.state(stamp).of_frame(T_base_imu);
    samples.push_back({stamp,
                       state.T_map_base.rotation.conjugate() * state.velocity_map +
                           normal3(random, kVelocityNoise),
                       state.angular_velocity_base + normal3(random, kGyroNoise)});
  }
  return samples;
}

std::vector<GnssFix> sample_gnss(const SmoothTrajectory& trajectory,
                                 const Eigen::Vector3d& p_base_antenna, double rate, double noise,
                                 const std::vector<GnssOutage>& outages,
                                 const std::vector<GnssJump>& jumps, std::uint64_t seed) {
  const GeographicLib::LocalCartesian geodesy(kDatum.latitude_deg, kDatum.longitude_deg,
                                              kDatum.altitude_m);
  const Eigen::Vector3d sigma(noise, noise, 1.5 * noise);
  const Stamp period = from_seconds(1.0 / rate);
  Random random(seed);
  std::vector<GnssFix> fixes;
  for (Stamp stamp = trajectory.begin(); stamp <= trajectory.end(); stamp += period) {
    const double seconds = to_seconds(stamp - trajectory.begin());
    const Eigen::Vector3d error = sigma.cwiseProduct(normal3(random, 1.0));
    if (lies_in(outages, seconds)) {
      fixes.push_back(without_fix(stamp));
      continue;
    }
    const Eigen::Vector3d p_map =
        trajectory.pose(stamp) * p_base_antenna + error + jump_offset(jumps, seconds);
    GnssFix fix{stamp, 0.0, 0.0, 0.0, 2, sigma.cwiseAbs2().asDiagonal().toDenseMatrix()};
    geodesy.Reverse(p_map.x(), p_map.y(), p_map.z(), fix.latitude_deg, fix.longitude_deg,
                    fix.altitude_m);
    fixes.push_back(fix);
  }
  return fixes;
}

}  // namespace lidar_mapping::simulation
