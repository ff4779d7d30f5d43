// SPDX-License-Identifier: BSD-3-Clause
// What is said once, and what is looked up until it is known.

#include <limits>
#include <map>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/diagnostic_log.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

namespace lidar_mapping::preprocessing {
namespace {

/// The messages since the last call, a line each, warnings with an exclamation mark.
std::string taken(DiagnosticLog& log) {
  std::string text;
  for (const Diagnostic& diagnostic : log.take()) {
    text += diagnostic.text + (diagnostic.level == Diagnostic::Level::kWarning ? "!\n" : "\n");
  }
  return text;
}

TEST(DiagnosticLog, SaysEachSubjectOnce) {
  DiagnosticLog log;
  log.warn("gyro", "the gyro is clipped");
  log.inform("motion", "compensated by IMU");
  log.warn("gyro", "the gyro is clipped again");
  EXPECT_EQ(taken(log), "the gyro is clipped!\ncompensated by IMU\n");
  log.warn("gyro", "the gyro is clipped once more");
  EXPECT_EQ(taken(log), "") << "taking the messages does not forget their subjects";
}

TEST(DiagnosticLog, SaysASubjectAgainAfterItsReset) {
  DiagnosticLog log;
  log.warn("gyro", "first");
  log.warn("clock", "other");
  log.reset("gyro");
  log.warn("clock", "not again");
  log.warn("gyro", "second");
  EXPECT_EQ(taken(log), "first!\nother!\nsecond!\n");
}

/// Frames that are found, and how often each was asked for.
struct Frames {
  std::map<std::string, Pose> known;
  std::map<std::string, int> asked;

  Extrinsics extrinsics() {
    return Extrinsics([this](const std::string& frame) -> std::optional<Pose> {
      ++asked[frame];
      const auto found = known.find(frame);
      if (found == known.end()) return std::nullopt;
      return found->second;
    });
  }
};

Pose mounted_at(double x) { return {Eigen::Quaterniond::Identity(), {x, 0.0, 1.0}}; }

TEST(Extrinsics, AskUntilAFrameIsFoundAndKeepItsPose) {
  Frames frames;
  const Extrinsics extrinsics = frames.extrinsics();
  EXPECT_FALSE(extrinsics.T_base("lidar"));
  EXPECT_FALSE(extrinsics.T_base("lidar"));
  EXPECT_EQ(frames.asked["lidar"], 2);
  frames.known["lidar"] = mounted_at(1.5);
  ASSERT_TRUE(extrinsics.T_base("lidar"));
  frames.known["lidar"] = mounted_at(9.0);
  EXPECT_EQ(extrinsics.T_base("lidar")->translation.x(), 1.5) << "sensors are fixed";
  EXPECT_EQ(frames.asked["lidar"], 3);
}

TEST(Extrinsics, DistinguishFrames) {
  Frames frames;
  frames.known["front"] = mounted_at(2.0);
  frames.known["rear"] = mounted_at(-1.0);
  const Extrinsics extrinsics = frames.extrinsics();
  EXPECT_EQ(extrinsics.T_base("front")->translation.x(), 2.0);
  EXPECT_EQ(extrinsics.T_base("rear")->translation.x(), -1.0);
  EXPECT_EQ(extrinsics.T_base("front")->translation.x(), 2.0);
}

TEST(Extrinsics, WaitForAPoseThatIsFinite) {
  Frames frames;
  frames.known["lidar"] = mounted_at(std::numeric_limits<double>::quiet_NaN());
  const Extrinsics extrinsics = frames.extrinsics();
  EXPECT_FALSE(extrinsics.T_base("lidar"));
  frames.known["lidar"] = mounted_at(1.0);
  EXPECT_TRUE(extrinsics.T_base("lidar"));
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
