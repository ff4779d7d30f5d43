// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/sensor_noise.hpp"

namespace lidar_mapping::simulation {
namespace {

DriveOptions options_with(const std::string& grade, const std::vector<std::string>& faults = {}) {
  DriveOptions options;
  options.drive = "handheld";
  options.lidar = "vlp16";
  options.imu = grade;
  for (const std::string& fault : faults) add_fault(options, fault);
  return options;
}

std::vector<ImuSample> ideal(const std::vector<std::string>& faults = {}) {
  return Drive(options_with("ideal", faults)).imu();
}

const std::vector<ImuSample>& truth() {
  static const std::vector<ImuSample> samples = ideal();
  return samples;
}

/// Standard deviation of the error that a fault adds to the first axis, without its mean.
double scatter(const std::vector<ImuSample>& samples, std::size_t count,
               const Eigen::Vector3d ImuSample::*value) {
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double error = (samples[i].*value - truth()[i].*value).x();
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(count);
  return std::sqrt(squares / n - sum * sum / (n * n));
}

/// Standard deviation of the noise that a grade adds to the first axis. It is computed from the
/// differences of successive errors, because the effects of scale and misalignment change slowly.
double noise(const std::vector<ImuSample>& samples, std::size_t count,
             const Eigen::Vector3d ImuSample::*value) {
  const auto error = [&](std::size_t i) { return (samples[i].*value - truth()[i].*value).x(); };
  double squares = 0.0;
  for (std::size_t i = 0; i < count; ++i) squares += std::pow(error(i + 1) - error(i), 2);
  return std::sqrt(squares / (2.0 * static_cast<double>(count)));
}

TEST(Imu, ConsumerGradeHasNoiseOfItsDensityAndNoOrientation) {
  const auto samples = Drive(options_with("consumer")).imu();
  ASSERT_EQ(samples.size(), truth().size());
  EXPECT_FALSE(samples.front().orientation);
  // 0.015 degrees/s and 230 micro-g per root of Hz, at 200 Hz.
  EXPECT_NEAR(noise(samples, 500, &ImuSample::angular_velocity), 2.6e-4 * std::sqrt(200.0), 5e-4);
  EXPECT_NEAR(noise(samples, 500, &ImuSample::linear_acceleration), 2.3e-3 * std::sqrt(200.0),
              5e-3);
}

TEST(Imu, ConsumerGradeHasDifferentErrorsPerSeed) {
  const auto mean_error = [](std::uint64_t seed) {
    DriveOptions options = options_with("consumer");
    options.seed = seed;
    const auto measured = Drive(options).imu();
    options.imu = "ideal";
    const auto exact = Drive(options).imu();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 400; ++i) {
      sum += measured[i].linear_acceleration - exact[i].linear_acceleration;
    }
    return Eigen::Vector3d(sum / 400.0);
  };
  const Eigen::Vector3d one = mean_error(1), other = mean_error(2);
  EXPECT_GT(one.norm(), 0.05);
  EXPECT_LT(one.norm(), 1.5);
  EXPECT_GT((one - other).norm(), 0.05);
}

TEST(Imu, SaturatesAtItsRange) {
  DriveOptions options = options_with("consumer");
  options.drive = "legged";
  double largest = 0.0;
  for (const ImuSample& s : Drive(options).imu()) {
    largest = std::max(largest, s.linear_acceleration.cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(largest, 4.0 * kGravity);
  largest = 0.0;
  for (const ImuSample& s : ideal({"imu_clip=1.1,0.5"})) {
    EXPECT_LE(s.angular_velocity.cwiseAbs().maxCoeff(), 0.5);
    largest = std::max(largest, s.linear_acceleration.cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(largest, 1.1 * kGravity);
}

TEST(Imu, FaultsGiveGapsAndDeadAxes) {
  const auto with_gaps = ideal({"imu_gap=2,10"});
  Stamp longest = 0;
  for (std::size_t i = 1; i < with_gaps.size(); ++i) {
    longest = std::max(longest, with_gaps[i].stamp - with_gaps[i - 1].stamp);
  }
  EXPECT_NEAR(to_seconds(longest), 2.0, 0.011);
  EXPECT_NEAR(static_cast<double>(with_gaps.size()) / static_cast<double>(truth().size()), 0.82,
              0.04);
  for (const ImuSample& s : ideal({"imu_axis=gz"})) ASSERT_EQ(s.angular_velocity.z(), 0.0);
  for (const ImuSample& s : ideal({"imu_axis=ay"})) ASSERT_EQ(s.linear_acceleration.y(), 0.0);
}

TEST(Imu, FaultsGiveWrongUnitsScaleFrameAndStamps) {
  constexpr std::size_t kMoving = 3000;
  const ImuSample& correct = truth()[kMoving];
  const auto faulty_sample = [](const char* fault) { return ideal({fault})[kMoving]; };
  const auto near = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).norm() < 1e-9;
  };
  EXPECT_TRUE(near(faulty_sample("imu_units=g").linear_acceleration,
                   correct.linear_acceleration / kGravity));
  EXPECT_TRUE(near(faulty_sample("imu_units=degrees").angular_velocity,
                   correct.angular_velocity * 180.0 / M_PI));
  EXPECT_TRUE(
      near(faulty_sample("imu_scale=0.1").angular_velocity, 1.1 * correct.angular_velocity));
  const ImuSample rotated = faulty_sample("imu_frame");
  EXPECT_NEAR(rotated.angular_velocity.x(), -correct.angular_velocity.y(), 1e-9);
  EXPECT_NEAR(rotated.linear_acceleration.y(), correct.linear_acceleration.x(), 1e-9);
  // The whole unit is rotated, and so is its orientation.
  EXPECT_TRUE(near(*rotated.orientation * rotated.linear_acceleration,
                   *correct.orientation * correct.linear_acceleration));
  EXPECT_EQ(faulty_sample("imu_offset=0.02").stamp, correct.stamp + 20'000'000);
}

TEST(Imu, VibrationHasGivenStrength) {
  const auto vibrating = ideal({"imu_vibration=5"});
  EXPECT_NEAR(scatter(vibrating, 2000, &ImuSample::linear_acceleration), 5.0, 0.5);
  EXPECT_NEAR(scatter(vibrating, 2000, &ImuSample::angular_velocity), 0.05, 0.005);
}

TEST(Imu, IsTheSameForTheSameSeed) {
  const auto faults = {"imu_vibration=2", "imu_clip=3"};
  const DriveOptions options = options_with("consumer", {faults.begin(), faults.end()});
  const auto one = Drive(options).imu(), other = Drive(options).imu();
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); i += 7) {
    ASSERT_EQ(one[i].angular_velocity, other[i].angular_velocity);
    ASSERT_EQ(one[i].linear_acceleration, other[i].linear_acceleration);
  }
}

TEST(Imu, RejectsInvalidFaults) {
  for (const char* text :
       {"imu_fog=1", "imu_clip", "imu_clip=0", "imu_clip=3,0", "imu_gap=nan", "imu_axis=bx",
        "imu_axis=2", "imu_units=kg", "imu_frame=1", "imu_offset=2", "imu_vibration=-1"}) {
    EXPECT_THROW(parse_imu_fault(text), ConfigError) << text;
  }
  DriveOptions options;
  EXPECT_THROW(add_fault(options, "fog"), ConfigError);
  options.imu = "bad";
  EXPECT_THROW(Drive{options}, ConfigError);
}

}  // namespace
}  // namespace lidar_mapping::simulation
