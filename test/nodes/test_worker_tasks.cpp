// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/messages.hpp"

#include "worker_tasks.hpp"

namespace lidar_mapping::ros_border {
namespace {

class AskedWorker : public testing::Test {
 protected:
  /// What a service answers whose work is `make`.
  template <typename Make>
  SaveMap::Response ask(const Make& make) {
    SaveMap::Response response;
    EXPECT_TRUE(answered(response, [&] { return result_in(worker_, channel_, make); }));
    return response;
  }

  Worker worker_{[](const std::string&, const std::string&) {}};
  Worker::ChannelId channel_ = worker_.add_channel("requests", 10);
};

TEST_F(AskedWorker, GivesWhatItMakes) {
  const SaveMap::Response response = ask([] {
    SaveMap::Response made;
    made.success = true;
    made.message = "saved";
    return made;
  });
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.message, "saved");
}

// A full disk was said to be the end of the node.
TEST_F(AskedWorker, SaysWhyItCouldNot) {
  const SaveMap::Response response =
      ask([]() -> SaveMap::Response { throw FileError("no space left"); });
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.message, "no space left");
}

TEST_F(AskedWorker, SaysThatItHasEnded) {
  worker_.stop();
  const SaveMap::Response response = ask([] { return SaveMap::Response(); });
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.message, "the node is ending");
}

}  // namespace
}  // namespace lidar_mapping::ros_border
