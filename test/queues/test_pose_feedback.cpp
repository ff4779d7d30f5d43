// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <future>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "threads/pose_feedback.hpp"

namespace lidar_mapping::pipeline {
namespace {

MovedPoses poses_of(std::uint32_t revision) {
  auto poses = std::make_shared<KeyFramePoses>();
  poses->revision = revision;
  return poses;
}

// Whichever is faster, a step sees the same.
TEST(PoseFeedback, GivesWhatTheGraphLeftFourStepsBefore) {
  constexpr std::uint32_t kSteps = 200;
  PoseFeedback feedback;
  auto search = std::async(std::launch::async, [&] {
    std::vector<MovedPoses> seen;
    for (std::uint32_t step = 0; step < kSteps; ++step) seen.push_back(feedback.wait_for_step());
    return seen;
  });
  for (std::uint32_t step = 0; step < kSteps; ++step) feedback.add_step(poses_of(step));
  const std::vector<MovedPoses> seen = search.get();
  for (std::size_t step = 0; step < kSteps; ++step) {
    if (step < PoseFeedback::kLag) {
      EXPECT_EQ(seen[step], nullptr);
    } else {
      EXPECT_EQ(seen[step]->revision, step - PoseFeedback::kLag);
    }
  }
}

// The search waited for a graph that had failed.
TEST(PoseFeedback, NobodyWaitsForAGraphThatFailed) {
  PoseFeedback feedback;
  for (std::size_t step = 0; step < PoseFeedback::kLag; ++step) feedback.wait_for_step();
  auto search = std::async(std::launch::async, [&] { return feedback.wait_for_step(); });
  feedback.close();
  EXPECT_EQ(search.get(), nullptr);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
