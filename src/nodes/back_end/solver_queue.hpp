// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/worker.hpp"

namespace lidar_mapping::ros_border {

/// Result of an optimisation.
struct SolvedProblem {
  std::shared_ptr<pipeline::RecordedBackEnd> run;  ///< the run to which the problem belongs
  std::shared_ptr<const back_end::OptimizationSolution> solution;  ///< null if it failed
  std::string failure;                                             ///< reason, if it failed
  bool thorough = false;  ///< every loop and position was evaluated again, as optimize_map asks
  double seconds = 0.0;   ///< computing time
};

/// Solves one optimisation at a time in a thread of its own, and keeps the requests of optimize_map
/// until they can be answered: a request that arrives during an optimisation waits for the next
/// one, because the present one does not have the newest data. All but the constructor is called in
/// the thread of `worker`.
class SolverQueue {
 public:
  using Answer = std::promise<OptimizeMap::Response>;
  using Apply = std::function<void(const SolvedProblem&)>;

  /// `apply` is called in the thread of `worker` for each result, and has to call finish(). If it
  /// throws before that, it is called once more with the error as the failure.
  SolverQueue(Worker& worker, Apply apply);

  /// Whether an optimisation is running.
  bool is_solving() const { return is_solving_; }
  /// Starts the optimisation of `run`.
  void solve(const std::shared_ptr<pipeline::RecordedBackEnd>& run, bool thorough);
  /// Keeps a request until the optimisation that has its data is finished.
  void add_request(Answer answer);
  /// Whether requests wait for the present optimisation.
  bool has_requests() const { return !answers_.empty(); }
  /// Marks the optimisation as finished.
  void finish() { is_solving_ = false; }
  /// Answers the requests that waited for the finished optimisation. Afterwards those wait that
  /// arrived during it.
  void answer(const OptimizeMap::Response& response);

  /// Drops all requests, so that their callers get an error.
  void drop_requests();
  /// Ends the thread. May be called from any thread.
  void stop() { solver_.stop(); }

 private:
  void apply(SolvedProblem solved);

  Worker& worker_;
  Apply apply_;
  bool is_solving_ = false;
  std::vector<Answer> answers_;       ///< requests that wait for the present optimisation
  std::vector<Answer> next_answers_;  ///< requests that wait for the one after it
  Worker::ChannelId solutions_;
  Worker solver_;
  Worker::ChannelId problems_;
};

}  // namespace lidar_mapping::ros_border
