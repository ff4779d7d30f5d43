#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "ride.hpp"

namespace lidar_mapping::front_end {
namespace {

simulation::Drive carried_drive(const std::string& name, double duration,
                                const std::string& fault = "") {
  simulation::DriveOptions options;
  options.drive = name;
  options.lidar = "vlp16";
  options.seed = 3;
  options.duration = duration;
  options.imu = "consumer";
  if (!fault.empty()) simulation::add_fault(options, fault);
  return simulation::Drive(options);
}

/// The samples of a drive's IMU sweep by sweep, as preprocessing hands them on.
class Samples {
 public:
  explicit Samples(const simulation::Drive& drive)
      : samples_(drive.imu()), T_base_imu_(drive.mounting().T_base_imu) {}

  MotionPrior until(Stamp end) {
    MotionPrior prior;
    prior.imu.emplace();
    prior.imu->p_base_imu = T_base_imu_.translation;
    for (; next_ < samples_.size() && samples_[next_].stamp <= end; ++next_) {
      ImuSample sample = samples_[next_];
      sample.angular_velocity = T_base_imu_.rotation * sample.angular_velocity;
      sample.linear_acceleration = T_base_imu_.rotation * sample.linear_acceleration;
      prior.imu->samples.push_back(sample);
    }
    return prior;
  }

 private:
  std::vector<ImuSample> samples_;
  Pose T_base_imu_;
  std::size_t next_ = 0;
};

struct Outcome {
  std::size_t lost = 0;
  std::size_t with_imu = 0;    ///< scans
  std::size_t distrusted = 0;  ///< likewise
  double error = 0.0;          ///< m, at the end
};

Outcome follow(const simulation::Drive& drive, bool with_imu) {
  Ride ride(drive);
  Samples samples(drive);
  Outcome outcome;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Stamp end = drive.scan_stamp(i) + from_seconds(0.11);
    const FrontEndStatus& status =
        ride.take(i, with_imu ? samples.until(end) : MotionPrior{}).status;
    outcome.lost += status.state == TrackingState::kLost ? 1 : 0;
    outcome.with_imu += status.imu == ImuUse::kFull ? 1 : 0;
    outcome.distrusted += status.imu == ImuUse::kDistrusted ? 1 : 0;
  }
  outcome.error = ride.error();
  return outcome;
}

// F: 5 rad/s on the spot, with a sensor that sees 30 degrees.
TEST(CarriedDrive, QuickTurnsAreFollowedWithAnImu) {
  const simulation::Drive drive = carried_drive("spin", 12.0);
  const Outcome with = follow(drive, true);
  EXPECT_EQ(with.lost, 0U);
  EXPECT_GT(with.with_imu, drive.scan_count() / 2);
  EXPECT_LT(with.error, 0.03);
}

TEST(CarriedDrive, GaitIsFollowedWithAnImu) {
  const simulation::Drive drive = carried_drive("handheld", 15.0);
  const Outcome with = follow(drive, true);
  EXPECT_EQ(with.lost, 0U);
  EXPECT_GT(with.with_imu, drive.scan_count() / 2);
  EXPECT_LT(with.error, 0.03);
}

// F: an IMU that is wrong never makes it worse than none.
TEST(CarriedDrive, AnImuThatIsWrongIsLeftOut) {
  for (const char* fault : {"imu_units=degrees", "imu_axis=gz", "imu_units=g"}) {
    SCOPED_TRACE(fault);
    const simulation::Drive drive = carried_drive("handheld", 15.0, fault);
    const Outcome with = follow(drive, true);
    const Outcome without = follow(drive, false);
    EXPECT_LE(with.lost, without.lost);
    EXPECT_LT(with.error, 1.5 * without.error + 0.02);
  }
}

// F: cut for two seconds in mid-walk.
TEST(CarriedDrive, AnImuMayFailForSeconds) {
  const simulation::Drive drive = carried_drive("handheld", 15.0, "imu_gap=2,6");
  const Outcome with = follow(drive, true);
  EXPECT_EQ(with.lost, 0U);
  EXPECT_LT(with.error, 0.05);
}

}  // namespace
}  // namespace lidar_mapping::front_end
