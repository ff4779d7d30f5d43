// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "clouds/ouster_clock.hpp"

namespace lidar_mapping::ros_border {
namespace {

constexpr Stamp kBegin = 1'700'000'000'000'000'000;  // ns
constexpr Stamp kStep = 1'000'000;                   // ns between packets

/// Packets of a sensor whose clock is `ahead` of that of ROS; only each tenth comes at once.
class OusterClocks : public testing::Test {
 protected:
  void send(int packets, Stamp ahead) {
    for (int i = 0; i < packets; ++i, now_ += kStep) {
      const Stamp delay = i % 10 == 0 ? 0 : (1 + i % 7) * kStep;
      tracker_.add(now_ + ahead - delay, now_);
    }
  }
  /// How far a time of the sensor's is off, s.
  double error(Stamp ahead) const {
    return to_seconds(tracker_.clock().to_ros(now_ + ahead) - now_);
  }

  OusterClockTracker tracker_;
  Stamp now_ = kBegin;
};

TEST_F(OusterClocks, ThoseOfRosAndOfPtpAreExact) {
  EXPECT_EQ(error(0), 0.0) << "before the first packet";
  send(50, 0);
  EXPECT_EQ(error(0), 0.0);
  OusterClockTracker ptp;
  const Stamp ahead = from_seconds(37.0);
  ptp.add(kBegin + ahead, kBegin + from_seconds(0.01));
  EXPECT_EQ(ptp.clock().to_ros(kBegin + ahead), kBegin);
}

TEST_F(OusterClocks, OneOfItsOwnHasTheOffsetOfTheSoonestPackets) {
  const Stamp ahead = -kBegin + 12'345'678;
  send(15, ahead);
  EXPECT_EQ(error(ahead), 0.0);
}

TEST_F(OusterClocks, ADriftIsFollowed) {
  Stamp ahead = -kBegin + 12'345'678;
  for (int step = 0; step < 600; ++step, ahead -= 100'000) send(100, ahead);  // 1e-3
  EXPECT_NEAR(error(ahead), 0.0, 3e-3) << "it lags by at most two seconds of the drift";
}

TEST_F(OusterClocks, ASensorThatBeginsAnewIsFollowed) {
  send(3000, -kBegin);
  now_ += from_seconds(20.0);
  const Stamp begun = -now_ + from_seconds(500.0);
  send(11, begun);
  EXPECT_EQ(error(begun), 0.0) << "at once, after a pause";
  const Stamp later = begun - from_seconds(100.0);
  send(2500, later);
  EXPECT_EQ(error(later), 0.0) << "within two seconds without one";
}

TEST_F(OusterClocks, ADamagedTimeMovesNothing) {
  const Stamp ahead = -kBegin + 12'345'678;
  send(100, ahead);
  for (const Stamp damaged : {Stamp{0}, Stamp{-1}, Stamp{1} << 62U, (Stamp{1} << 62U) + 1}) {
    tracker_.add(damaged, now_);
    send(1, ahead);
    EXPECT_EQ(error(ahead), 0.0) << damaged;
  }
  EXPECT_THROW(tracker_.clock().to_ros(-1), InputError);
}

TEST_F(OusterClocks, NothingIsLearntBeforeRosHasATime) {
  tracker_.add(kBegin, 0);
  EXPECT_EQ(tracker_.clock().to_ros(kBegin), kBegin);
  now_ += from_seconds(3.0);
  send(10, -kBegin);
  EXPECT_EQ(error(-kBegin), 0.0);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
