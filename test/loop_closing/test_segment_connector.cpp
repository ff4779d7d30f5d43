// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "decision/segment_connector.hpp"
#include "drive.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

/// A street in segment 0 and the same street again in segment 1, `gap` seconds later and in another
/// frame of odometry.
struct Streets {
  explicit Streets(double gap) {
    const auto poses = along({{0, 0}, {300, 0}});
    count = poses.size();
    const Pose T_new_old = planar(1000.0, -50.0, 1.0);
    for (std::size_t i = 0; i < 2 * count; ++i) {
      KeyFrame key = key_frame(i, i < count ? poses[i] : T_new_old * poses[i - count]);
      key.segment = i < count ? 0 : 1;
      if (key.segment == 1) key.stamp += from_seconds(gap);
      trajectory.append(key);
    }
  }
  Loop match(std::size_t index, const Pose& T_from_to) const {
    Loop loop;
    loop.from = static_cast<KeyFrameIndex>(index);
    loop.to = static_cast<KeyFrameIndex>(index + count);
    loop.T_from_to = T_from_to;
    return loop;
  }
  std::size_t count;
  Trajectory trajectory;
};

TEST(SegmentConnector, AcceptsMatchesThatAgreeOverALongPath) {
  const Streets streets(1000.0);
  SegmentConnector connector(100.0);
  EXPECT_TRUE(connector.add(streets.match(10, planar(0.2, 1.0, 0.0)), streets.trajectory).empty());
  EXPECT_TRUE(connector.add(streets.match(40, planar(0.2, 1.0, 0.0)), streets.trajectory).empty());
  EXPECT_EQ(connector.add(streets.match(61, planar(0.2, 1.0, 0.0)), streets.trajectory).size(), 3U);
  EXPECT_EQ(connector.add(streets.match(64, planar(0.2, 1.0, 0.0)), streets.trajectory).size(), 1U);
}

TEST(SegmentConnector, DoesNotAcceptContradictingMatches) {
  const Streets streets(1000.0);
  SegmentConnector connector(100.0);
  connector.add(streets.match(10, planar(0.2, 1.0, 0.0)), streets.trajectory);
  EXPECT_TRUE(connector.add(streets.match(61, planar(9.0, 1.0, 0.0)), streets.trajectory).empty());
  EXPECT_TRUE(connector.add(streets.match(90, planar(0.2, 1.0, 0.5)), streets.trajectory).empty());
}

TEST(SegmentConnector, AcceptsOneMatchAfterAShortGap) {
  const Streets streets(1.0);
  SegmentConnector connector(100.0);
  Loop loop = streets.match(0, planar(1.0, 0.0, 0.0));
  loop.from = static_cast<KeyFrameIndex>(streets.count - 3);
  EXPECT_EQ(connector.add(loop, streets.trajectory).size(), 1U);
}

// The distance of two vehicles at the same time is not limited.
TEST(SegmentConnector, DoesNotAcceptOneMatchBetweenSimultaneousSegments) {
  const Streets streets(-60.0);
  SegmentConnector connector(100.0);
  Loop loop = streets.match(0, planar(1.0, 0.0, 0.0));
  loop.from = static_cast<KeyFrameIndex>(streets.count - 3);
  EXPECT_TRUE(connector.add(loop, streets.trajectory).empty());
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
