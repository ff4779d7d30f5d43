// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <future>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "threads/stage_thread.hpp"

namespace lidar_mapping::pipeline {
namespace {

TEST(StageThread, KeepsTheOrderAndBoundsWhatWaits) {
  std::vector<int> seen;
  std::atomic<int> waiting{0};
  int most = 0;
  StageThread<int> stage(3, true, [&](int&& item) {
    most = std::max(most, waiting--);
    seen.push_back(item);
  });
  for (int i = 0; i < 1000; ++i) {
    stage.push(i);
    ++waiting;
  }
  stage.finish();
  ASSERT_EQ(seen.size(), 1000U);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(seen[i], i);
  EXPECT_LE(most, 5);  // three in the queue, one in the hand, one counted late
}

TEST(StageThread, ThrowsToWhoPushesAndToWhoFinishes) {
  StageThread<int> stage(1, true, [](int&&) { throw std::runtime_error("no"); });
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) stage.push(i);
      },
      std::runtime_error);
  EXPECT_THROW(stage.finish(), std::runtime_error);
}

// What is broken off does not work off its queue first.
TEST(StageThread, DiscardsWaitingWorkWhenNobodyFinishesIt) {
  auto second = std::make_shared<int>(2);
  const std::weak_ptr<int> waits = second;
  std::promise<void> begun;
  int handled = 0;
  {
    StageThread<std::shared_ptr<int>> stage(3, true, [&](std::shared_ptr<int>&&) {
      ++handled;
      begun.set_value();
      while (!waits.expired()) std::this_thread::yield();
    });
    stage.push(std::make_shared<int>(1));
    stage.push(std::move(second));
    begun.get_future().wait();
  }
  EXPECT_EQ(handled, 1);
}

TEST(StageThread, WorksInThePushWithoutAThread) {
  std::vector<int> seen;
  StageThread<int> stage(1, false, [&](int&& item) { seen.push_back(item); });
  for (int i = 0; i < 3; ++i) {
    stage.push(i);
    EXPECT_EQ(seen.back(), i);
  }
  stage.finish();
}

TEST(StageThread, ReportsItsTimeWhileItWorks) {
  StageThread<int> stage(1, true, [](int&&) {});
  double seconds = 0.0;
  for (int i = 0; i < 100; ++i) {
    stage.push(i);
    EXPECT_GE(stage.seconds(), seconds);
    seconds = stage.seconds();
  }
  stage.finish();
  EXPECT_GE(stage.seconds(), seconds);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
