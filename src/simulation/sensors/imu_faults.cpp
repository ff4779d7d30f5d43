// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/imu_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

#include "sensors/fault_text.hpp"

namespace lidar_mapping::simulation {

namespace {

using Kind = ImuFault::Kind;
using Samples = std::vector<ImuSample>;

constexpr double kNoLimit = 1e9;            ///< s; chosen: later than any drive ends
constexpr double kDefaultGapPeriod = 20.0;  ///< s; chosen: several gaps per drive

using Description = FaultDescription<Kind>;
constexpr Description kDescriptions[] = {
    {"imu_vibration", Kind::kVibration, "imu_vibration=M_PER_S2 from 0.01 to 200", 0.01, 200.0},
    {"imu_scale", Kind::kScale, "imu_scale=FRACTION from -0.9 to 9", -0.9, 9.0},
    {"imu_axis", Kind::kAxis, "imu_axis=gx, gy, gz, ax, ay or az", 0.0, 0.0},
    {"imu_clip", Kind::kClip, "imu_clip=G or imu_clip=G,RAD_PER_S, both 0.01 or more", 0.01, 1e6},
    {"imu_frame", Kind::kFrame, "imu_frame without a number", 0.0, 0.0},
    {"imu_units", Kind::kUnits, "imu_units=g or imu_units=degrees", 0.0, 0.0},
    {"imu_offset", Kind::kOffset, "imu_offset=SECONDS from -1 to 1", -1.0, 1.0},
    {"imu_gap", Kind::kGap, "imu_gap=SECONDS or imu_gap=SECONDS,EVERY_SECONDS, 0.01 or more", 0.01,
     1e6}};

/// Finds the position of `word` among `words`; false if it is none of them.
template <std::size_t N>
bool find_word(const std::array<const char*, N>& words, const std::string& word, double& position) {
  const auto found = std::find(words.begin(), words.end(), word);
  position = static_cast<double>(found - words.begin());
  return found != words.end();
}

bool read(const Description& known, const std::optional<std::string>& value, ImuFault& fault) {
  constexpr std::array<const char*, 6> kAxes = {"gx", "gy", "gz", "ax", "ay", "az"};
  constexpr std::array<const char*, 2> kUnits = {"g", "degrees"};
  fault.other = known.kind == Kind::kGap ? kDefaultGapPeriod : kNoLimit;
  if (known.kind == Kind::kFrame) return !value;
  if (!value) return false;
  if (known.kind == Kind::kAxis) return find_word(kAxes, *value, fault.amount);
  if (known.kind == Kind::kUnits) return find_word(kUnits, *value, fault.amount);
  const bool may_have_two_numbers = known.kind == Kind::kClip || known.kind == Kind::kGap;
  return read_numbers(*value, known, fault.amount, may_have_two_numbers ? &fault.other : nullptr) &&
         fault.other >= 0.01 && fault.other <= 1e9;
}

void vibrate(Samples& samples, double amount, Stamp begin, std::uint64_t seed) {
  // Frequency of the rotors (5000 turns a minute) and its strongest harmonic; the housing transmits
  // their vibration to the gyroscope as well. Chosen.
  constexpr double kHz = 83.0;
  constexpr double kHarmonic = 2.0;
  constexpr double kRatePerAcceleration = 0.01;  // rad/s per m/s^2
  Random random(seed);
  std::array<double, 12> phase{};
  for (double& p : phase) p = random.uniform(0.0, 2.0 * kPi);
  for (ImuSample& sample : samples) {
    const double angle = 2.0 * kPi * kHz * to_seconds(sample.stamp - begin);
    const auto vibration = [&](int axis) {
      return std::sin(angle + phase[2 * axis]) + std::sin(kHarmonic * angle + phase[2 * axis + 1]);
    };
    for (int axis = 0; axis < 3; ++axis) {
      sample.linear_acceleration(axis) += amount * vibration(axis);
      sample.angular_velocity(axis) += kRatePerAcceleration * amount * vibration(3 + axis);
    }
  }
}

void rotate_by_quarter(ImuSample& sample) {
  const Eigen::Quaterniond R_quarter = rotation_about_z(0.5 * kPi);
  sample.angular_velocity = R_quarter * sample.angular_velocity;
  sample.linear_acceleration = R_quarter * sample.linear_acceleration;
  if (sample.orientation) *sample.orientation = *sample.orientation * R_quarter.conjugate();
}

void clip(Eigen::Vector3d& values, double max) { values = values.cwiseMax(-max).cwiseMin(max); }

/// Applies a fault that changes each sample alone.
void corrupt(ImuSample& sample, const ImuFault& fault) {
  switch (fault.kind) {
    case Kind::kScale:
      sample.angular_velocity *= 1.0 + fault.amount;
      sample.linear_acceleration *= 1.0 + fault.amount;
      break;
    case Kind::kAxis: {
      const int axis = static_cast<int>(fault.amount);
      (axis < 3 ? sample.angular_velocity : sample.linear_acceleration)(axis % 3) = 0.0;
      break;
    }
    case Kind::kClip:
      clip(sample.linear_acceleration, fault.amount * kGravity);
      clip(sample.angular_velocity, fault.other);
      break;
    case Kind::kFrame:
      rotate_by_quarter(sample);
      break;
    case Kind::kUnits:
      if (fault.amount == 0.0) sample.linear_acceleration /= kGravity;
      if (fault.amount == 1.0) sample.angular_velocity *= kDegPerRad;
      break;
    case Kind::kOffset:
      sample.stamp += from_seconds(fault.amount);
      break;
    case Kind::kVibration:
    case Kind::kGap:
      break;
  }
}

void make_gaps(Samples& samples, const ImuFault& fault, Stamp begin) {
  const auto is_missing = [&](const ImuSample& sample) {
    const double seconds = to_seconds(sample.stamp - begin);
    // The drive does not begin with a gap.
    return seconds >= fault.other && std::fmod(seconds, fault.other) < fault.amount;
  };
  samples.erase(std::remove_if(samples.begin(), samples.end(), is_missing), samples.end());
}

}  // namespace

ImuFault parse_imu_fault(const std::string& text) {
  return parse_fault<ImuFault>(text, kDescriptions, read);
}

std::vector<std::string> imu_fault_formats() { return fault_formats(kDescriptions); }

void corrupt(std::vector<ImuSample>& samples, const std::vector<ImuFault>& faults, Stamp begin,
             std::uint64_t seed) {
  for (const Description& next : kDescriptions) {
    for (const ImuFault& fault : faults) {
      if (fault.kind != next.kind) continue;
      if (fault.kind == Kind::kVibration) vibrate(samples, fault.amount, begin, seed);
      if (fault.kind == Kind::kGap) make_gaps(samples, fault, begin);
      for (ImuSample& sample : samples) corrupt(sample, fault);
    }
  }
}

}  // namespace lidar_mapping::simulation
