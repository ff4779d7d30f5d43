// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/NavSatFix.h>

#include "mapped_drive.hpp"
#include "rewritten_bag.hpp"

namespace lidar_mapping::tools {
namespace {

using session::Session;

class WildFix : public test::MappedDrive {
 protected:
  /// The bag with the first `count` fixes five degrees (550 km) farther north.
  static void copy_with_wild_fixes(const std::string& to, int count) {
    test::rewrite_bag(bag(), to, [&](rosbag::Bag& copy, const rosbag::MessageInstance& message) {
      const auto fix = message.instantiate<sensor_msgs::NavSatFix>();
      if (!fix || count-- <= 0) return false;
      fix->latitude += 5.0;
      copy.write(message.getTopic(), message.getTime(), fix);
      return true;
    });
  }

  static double farthest(const Session& session) {
    double metres = 0.0;
    for (const auto& pose : session.poses().poses) {
      metres = std::max(metres, pose.T_map_base.translation.norm());
    }
    return metres;
  }
};

TEST_F(WildFix, AtTheStartIsLeftOut) {
  const std::string wild = folder_.path() / "wild.bag", town = folder_.path() / "town";
  copy_with_wild_fixes(wild, 1);
  ASSERT_EQ(run("map_bag", {wild, "-o", town, "--formats", "pcd"}), 0);
  EXPECT_TRUE(has_said("the first fix is 556 km from the next ones, which agree"));
  const Session session = opened(town);
  const Session undisturbed = opened(whole());
  ASSERT_TRUE(session.datum());
  EXPECT_NEAR(session.datum()->latitude_deg, undisturbed.datum()->latitude_deg, 1e-4);
  EXPECT_GT(session.gnss().size() + 5, undisturbed.gnss().size());
  EXPECT_LT(farthest(session), farthest(undisturbed) + 10.0);
}

/// Nobody knows then which ones are right; the map is made all the same.
TEST_F(WildFix, OnesThatAgreeDoNotEndTheMap) {
  const std::string wild = folder_.path() / "wild.bag", town = folder_.path() / "town";
  copy_with_wild_fixes(wild, 20);
  ASSERT_EQ(run("map_bag", {wild, "-o", town, "--formats", "pcd"}), 0);
  EXPECT_TRUE(has_said("a jump: "));
  EXPECT_LT(farthest(opened(town)), 1000.0);
}

}  // namespace
}  // namespace lidar_mapping::tools
