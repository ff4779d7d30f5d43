// SPDX-License-Identifier: BSD-3-Clause
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "lidar_mapping/ros/worker.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Order = std::vector<int>;

void ignore(const std::string&, const std::string&) {}

/// Keeps the worker busy until it is released, so that what is posted meanwhile has to wait.
class Stall {
 public:
  Stall(Worker& worker, Worker::ChannelId channel) {
    worker.post(channel, [gates = gates_] {
      gates->begun.set_value();
      gates->released.wait();
    });
    gates_->begun.get_future().wait();
  }
  void release() { gates_->release.set_value(); }

 private:
  struct Gates {
    std::promise<void> begun, release;
    std::future<void> released = release.get_future();
  };
  /// The worker's too: it may still be on its way through a gate that others have passed.
  std::shared_ptr<Gates> gates_ = std::make_shared<Gates>();
};

TEST(Worker, TakesTasksOfAllChannelsInOrderOfArrival) {
  Order order;
  Worker worker(ignore);
  worker.drain_on_stop();
  const auto a = worker.add_channel("a", 10);
  const auto b = worker.add_channel("b", 10);
  Stall stall(worker, a);
  worker.post(b, [&] { order.push_back(1); });
  worker.post(a, [&] { order.push_back(2); });
  worker.post(b, [&] { order.push_back(3); });
  stall.release();
  worker.stop();
  EXPECT_EQ(order, (Order{1, 2, 3}));
}

// Queues grew without bound or lost messages in silence.
TEST(Worker, DropsTheOldestOfAFullChannelAndCountsIt) {
  Order order;
  Worker worker(ignore);
  worker.drain_on_stop();
  const auto gate = worker.add_channel("gate", 1);
  const auto scans = worker.add_channel("scans", 3);
  Stall stall(worker, gate);
  for (int i = 0; i < 8; ++i) worker.post(scans, [&order, i] { order.push_back(i); });
  EXPECT_EQ(worker.statistics()[scans].waiting, 3U);
  stall.release();
  worker.stop();
  EXPECT_EQ(order, (Order{5, 6, 7}));
  EXPECT_EQ(worker.statistics()[scans].dropped, 5U);
  EXPECT_EQ(worker.statistics()[scans].handled, 3U);
  EXPECT_EQ(worker.losses("scans"), 5U);
}

TEST(Worker, OtherChannelsLoseNothingWhenOneIsFull) {
  Order order;
  Worker worker(ignore);
  worker.drain_on_stop();
  const auto scans = worker.add_channel("scans", 1);
  const auto imu = worker.add_channel("imu", 10);
  Stall stall(worker, imu);
  worker.post(imu, [&] { order.push_back(-1); });
  for (int i = 0; i < 4; ++i) worker.post(scans, [&order, i] { order.push_back(i); });
  stall.release();
  worker.stop();
  EXPECT_EQ(order, (Order{-1, 3}));
}

TEST(Worker, DiscardsAndCountsWhatWaitsAtTheEnd) {
  bool ran = false;
  Worker worker(ignore);
  const auto channel = worker.add_channel("scans", 10);
  auto stall = std::make_unique<Stall>(worker, channel);
  worker.post(channel, [&] { ran = true; });
  auto stopping = std::async(std::launch::async, [&] { worker.stop(); });
  while (worker.statistics()[channel].dropped == 0) std::this_thread::yield();
  stall->release();
  stopping.wait();
  EXPECT_FALSE(ran);
  EXPECT_EQ(worker.statistics()[channel].dropped, 1U);
}

TEST(Worker, TakesNothingMoreAfterTheEnd) {
  Worker worker(ignore);
  const auto channel = worker.add_channel("scans", 10);
  worker.stop();
  worker.post(channel, [] { FAIL(); });
  EXPECT_EQ(worker.statistics()[channel].dropped, 1U);
}

// A node never dies of a message.
TEST(Worker, GoesOnAfterATaskThatThrows) {
  std::string said;
  bool ran = false;
  {
    Worker worker(
        [&](const std::string& channel, const std::string& what) { said = channel + ": " + what; });
    worker.drain_on_stop();
    const auto channel = worker.add_channel("scans", 10);
    worker.post(channel, [] { throw std::runtime_error("stamp goes back"); });
    worker.post(channel, [&] { ran = true; });
    worker.stop();
    EXPECT_EQ(worker.statistics()[channel].refused, 1U);
    EXPECT_EQ(worker.statistics()[channel].handled, 1U);
  }
  EXPECT_TRUE(ran);
  EXPECT_EQ(said, "scans: stamp goes back");
}

TEST(Worker, RunsTheIdleTaskOnceAfterWork) {
  std::promise<void> idle;
  Worker worker(ignore);
  const auto channel = worker.add_channel("scans", 10);
  worker.set_idle_task(std::chrono::milliseconds(1), [&] { idle.set_value(); });
  worker.post(channel, [] {});
  EXPECT_EQ(idle.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

// Computations blocked the handling of messages.
TEST(Worker, PostNeverWaitsForATask) {
  Worker worker(ignore);
  const auto channel = worker.add_channel("scans", 2);
  Stall stall(worker, channel);
  for (int i = 0; i < 1000; ++i) worker.post(channel, [] {});
  EXPECT_EQ(worker.statistics()[channel].waiting, 2U);
  stall.release();
}

}  // namespace
}  // namespace lidar_mapping::ros_border
