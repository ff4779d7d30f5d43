// SPDX-License-Identifier: BSD-3-Clause
#include <exception>
#include <string>

#include "lidar_mapping/ros/mapping_conversions.hpp"

#include "back_end/optimization_answer.hpp"
#include "back_end_node.hpp"

// When the graph is optimised, and how the solution is applied.
namespace lidar_mapping::ros_border {

void BackEndNode::optimize_if_due() {
  if (!solver_.is_solving() && run_->optimization_due()) start_solving(false);
}

void BackEndNode::start_solving(bool thorough) {
  solver_.solve(run_, thorough);
  report_state();
}

void BackEndNode::apply_solution(const SolvedProblem& solved) {
  MapOptimization done;
  done.report = back_end::report_of(*solved.solution);
  done.report.seconds = solved.seconds;
  done.save_map = context_.node.resolveName("save_map");
  if (solved.run == run_) {
    const KeyFramePoses before = run_->poses();
    const auto storage =
        solved.thorough ? pipeline::PoseStorage::kAlways : pipeline::PoseStorage::kWhenGrown;
    const pipeline::AppliedSolution applied =
        run_->apply(*solved.solution, solved.seconds, storage);
    done.moved = back_end::change_between(before, applied.poses);
    done.corrected = back_end::change_between(run_->odometry(), applied.poses);
    if (!applied.poses.poses.empty()) done.begin = applied.poses.poses.front().stamp;
    done.session = run_->session().directory().string();
    if (!applied.storing_failure.empty()) {
      const std::string problem =
          "the session does not have this solution yet: " + applied.storing_failure;
      ROS_ERROR_STREAM(problem);
      done.report.remarks.push_back(problem);
    }
    files_outdated_ = true;
    publish_poses(applied.poses, solved.thorough && done.report.success);
    publish_verdicts(applied.verdicts);
  }
  const back_end::OptimizationReport& report = done.report;
  context_.diagnostics.set("loops used", report.loops_used);
  context_.diagnostics.set("loops refused", report.loops_refused);
  context_.diagnostics.set("GNSS positions used", report.gnss_used);
  context_.diagnostics.set("GNSS positions refused", report.gnss_refused);
  context_.diagnostics.set("seconds per optimisation", solved.seconds);
  context_.diagnostics.set("last optimisation", report.message);
  failure_ = report.success ? "" : report.message;
  end_solving(to_answer(done));
}

/// The poses stay unchanged.
void BackEndNode::report_failure(const std::string& problem) {
  failure_ = "the optimisation failed: " + problem;
  ROS_ERROR_STREAM(failure_);
  OptimizeMap::Response answer;
  answer.message = failure_;
  end_solving(answer);
}

/// Answers the requests that waited for this optimisation, and starts the next one if it was
/// requested.
void BackEndNode::end_solving(OptimizeMap::Response answer) {
  solver_.finish();
  report_state();
  if (solver_.has_requests()) write_files_for(answer);
  if (!unstored_.empty()) answer.message += " " + unstored_.text() + ".";
  solver_.answer(answer);
  if (solver_.has_requests()) start_solving(true);
}

/// A caller gets an answer even if the files cannot be written.
void BackEndNode::write_files_for(OptimizeMap::Response& answer) {
  try {
    for (const std::string& warning : write_files()) {
      ROS_WARN_STREAM(warning);
      answer.message += " " + warning + ".";
    }
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
    answer.success = false;
    answer.message += std::string(" The files were not written: ") + error.what();
  }
}

/// Called with every key frame as well, because a drive without loops and GNSS is only optimised on
/// request.
void BackEndNode::report_state() {
  if (solver_.is_solving()) {
    context_.diagnostics.set_state(Diagnostics::Level::kOk, "optimising");
  } else if (!unstored_.empty()) {
    context_.diagnostics.set_state(Diagnostics::Level::kError, unstored_.text());
  } else if (!failure_.empty()) {
    context_.diagnostics.set_state(Diagnostics::Level::kWarning, failure_);
  } else if (run_) {
    context_.diagnostics.set_state(Diagnostics::Level::kOk, "mapping");
  }
}

void BackEndNode::publish_poses(const KeyFramePoses& poses, bool thorough) {
  if (poses_.publish(poses, thorough)) context_.diagnostics.count_output(poses.poses.back().stamp);
}

void BackEndNode::publish_verdicts(const std::vector<LoopVerdict>& verdicts) {
  for (const LoopVerdict& verdict : verdicts) {
    verdicts_.publish(to_message(verdict, run_id_, config_.node.base_frame));
  }
}

/// Writes the files of the session unless they are up to date. Returns the warnings about the
/// doubtful sections that were written.
std::vector<std::string> BackEndNode::write_files() {
  if (!run_ || !files_outdated_) return {};
  store_configuration();
  std::vector<std::string> warnings = run_->write_files();
  files_outdated_ = false;
  return warnings;
}

void BackEndNode::store_configuration() {
  if (!ros::ok()) return;  // the parameter server may be gone
  for (const auto& [stage, yaml] : effective_configurations(context_.node)) {
    run_->session().set_configuration(stage, yaml);
  }
}

}  // namespace lidar_mapping::ros_border
