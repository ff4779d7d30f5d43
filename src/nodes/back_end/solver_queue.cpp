// SPDX-License-Identifier: BSD-3-Clause
#include "back_end/solver_queue.hpp"

#include <exception>
#include <utility>

#include "lidar_mapping/ros/node.hpp"

namespace lidar_mapping::ros_border {

SolverQueue::SolverQueue(Worker& worker, Apply apply)
    : worker_(worker),
      apply_(std::move(apply)),
      solutions_(worker.add_channel("solutions", kPublisherQueue)),
      solver_([](const std::string&, const std::string& what) {
        ROS_ERROR_STREAM("optimisation failed: " << what);
      }),
      problems_(solver_.add_channel("problems", 1)) {}

void SolverQueue::solve(const std::shared_ptr<pipeline::RecordedBackEnd>& run, bool thorough) {
  is_solving_ = true;
  solver_.post(problems_, [this, problem = run->problem(thorough), run, thorough] {
    SolvedProblem solved;
    solved.run = run;
    solved.thorough = thorough;
    const ros::WallTime begin = ros::WallTime::now();
    try {
      solved.solution = back_end::solve(*problem);
    } catch (const std::exception& error) {
      solved.failure = error.what();
    }
    solved.seconds = (ros::WallTime::now() - begin).toSec();
    worker_.post(solutions_, [this, solved] { apply(solved); });
  });
}

/// A solution that cannot be applied is a failure as well: otherwise the node would wait for it for
/// ever. One that the session cannot store is applied (RecordedBackEnd::apply()).
void SolverQueue::apply(SolvedProblem solved) {
  try {
    apply_(solved);
  } catch (const std::exception& error) {
    if (!is_solving_) throw;
    solved.solution = nullptr;
    solved.failure = error.what();
    apply_(solved);
  }
}

void SolverQueue::add_request(Answer answer) {
  (is_solving_ ? next_answers_ : answers_).push_back(std::move(answer));
}

void SolverQueue::answer(const OptimizeMap::Response& response) {
  for (Answer& waiting : answers_) waiting.set_value(response);
  answers_ = std::move(next_answers_);
  next_answers_.clear();
}

void SolverQueue::drop_requests() {
  answers_.clear();
  next_answers_.clear();
}

}  // namespace lidar_mapping::ros_border
