// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "back_end/solver_queue.hpp"
#include "full_disk.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

OptimizeMap::Response response(const std::string& message) {
  OptimizeMap::Response response;
  response.message = message;
  return response;
}

class SolverQueueOfARun : public testing::Test {
 protected:
  /// Adds a request and returns its future answer.
  std::future<OptimizeMap::Response> request() {
    SolverQueue::Answer answer;
    std::future<OptimizeMap::Response> future = answer.get_future();
    queue_.add_request(std::move(answer));
    return future;
  }

  test::TemporaryFolder folder_;
  std::shared_ptr<pipeline::RecordedBackEnd> run_ = std::make_shared<pipeline::RecordedBackEnd>(
      session::Session::create_in(folder_.path() / "session"), back_end::BackEndConfig());
  std::promise<SolvedProblem> solved_;
  Worker worker_{[](const std::string&, const std::string&) {}};
  SolverQueue queue_{worker_, [this](const SolvedProblem& solved) { solved_.set_value(solved); }};
};

// A request has to be answered with data that were there when it came.
TEST_F(SolverQueueOfARun, AnswersARequestAfterTheNextOptimization) {
  auto before = request();
  queue_.solve(run_, true);
  EXPECT_TRUE(queue_.is_solving());
  auto during = request();
  const SolvedProblem solved = solved_.get_future().get();
  EXPECT_EQ(solved.run, run_);
  EXPECT_TRUE(solved.solution != nullptr || !solved.failure.empty());
  queue_.finish();
  EXPECT_FALSE(queue_.is_solving());
  queue_.answer(response("first"));
  EXPECT_EQ(before.get().message, "first");
  EXPECT_TRUE(queue_.has_requests());
  queue_.answer(response("second"));
  EXPECT_EQ(during.get().message, "second");
  EXPECT_FALSE(queue_.has_requests());
}

TEST_F(SolverQueueOfARun, ASolutionThatCannotBeAppliedHasFailed) {
  std::promise<std::string> failure;
  int calls = 0;
  SolverQueue queue(worker_, [&](const SolvedProblem& solved) {
    if (++calls == 1) throw std::runtime_error("no space left");
    queue.finish();
    failure.set_value(solved.failure);
  });
  queue.solve(run_, true);
  std::future<std::string> reported = failure.get_future();
  ASSERT_EQ(reported.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  EXPECT_EQ(reported.get(), "no space left");
  EXPECT_FALSE(queue.is_solving());
}

// The graph has moved: the callers get its report, and subscribers its poses.
TEST_F(SolverQueueOfARun, ASolutionThatCannotBeStoredHasNotFailed) {
  KeyFrame key_frame;
  key_frame.cloud = std::make_shared<const PointCloud>();
  run_->add_key_frame(key_frame);
  std::promise<std::pair<std::string, std::string>> failures;
  SolverQueue queue(worker_, [&](const SolvedProblem& solved) {
    std::string storing_failure;
    if (solved.solution) {
      const test::FullDisk full;
      storing_failure = run_->apply(*solved.solution, solved.seconds).storing_failure;
    }
    queue.finish();
    failures.set_value({solved.failure, storing_failure});
  });
  queue.solve(run_, true);
  auto reported = failures.get_future();
  ASSERT_EQ(reported.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  const auto [failure, storing_failure] = reported.get();
  EXPECT_EQ(failure, "");
  EXPECT_NE(storing_failure, "");
}

TEST_F(SolverQueueOfARun, CallersOfDroppedRequestsGetAnError) {
  auto answer = request();
  queue_.drop_requests();
  EXPECT_FALSE(queue_.has_requests());
  EXPECT_THROW(answer.get(), std::future_error);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
