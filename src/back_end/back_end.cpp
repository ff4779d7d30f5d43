// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/back_end/back_end.hpp"

#include <algorithm>

#include "drive/drive_results.hpp"
#include "drive/drive_update.hpp"
#include "drive/graph_builder.hpp"
#include "imu/tilt_scatter.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {

class BackEnd::Impl {
 public:
  explicit Impl(const BackEndConfig& config) : config_(config), builder_(config) {}

  GraphBuilder& builder() { return builder_; }
  DriveGraph& drive() { return drive_; }

  bool optimization_due() const {
    if (drive_.nodes.empty()) return false;
    const double elapsed = to_seconds(drive_.nodes.back().stamp - last_optimization_);
    if (elapsed >= 0.0 && elapsed < config_.optimize_min_interval) return false;
    if (full_solve_needed_) return true;
    const NewDataCounts& new_data = builder_.new_data();
    if (config_.use_loop_close && new_data.loops >= config_.optimize_step_with_loop) return true;
    if (config_.use_gnss && new_data.gnss >= gnss_optimization_step()) return true;
    // With odometry alone there is no contradiction to distribute.
    const bool has_corrections = (config_.use_loop_close && !drive_.loops.empty()) ||
                                 (config_.use_gnss && !drive_.gnss.empty());
    return has_corrections && new_data.key_frames >= config_.optimize_step_with_key_frame;
  }

  std::shared_ptr<const OptimizationProblem> problem(bool thorough) const {
    auto problem = std::make_shared<OptimizationProblem>();
    problem->config = config_;
    problem->key_frames = drive_.nodes.size();
    problem->thorough = thorough;
    if (!thorough && !full_solve_due()) problem->window = window_around_new_data(drive_, config_);
    problem->drive = problem->window ? extract_window(drive_, *problem->window) : drive_;
    problem->drive.tilt_stddev = tilt_stddev(drive_, config_);
    problem->usage = count_usage(drive_);
    return problem;
  }

  KeyFramePoses apply(const OptimizationSolution& solution) {
    if (solution.drive.nodes.empty() || solution.key_frames > drive_.nodes.size()) return poses();
    NewDataCounts new_data = builder_.new_data();
    if (solution.window) {
      apply_window(solution, new_data);
    } else {
      apply_whole(solution.drive, new_data);
    }
    new_data.key_frames = static_cast<int>(drive_.nodes.size() - solution.key_frames);
    builder_.set_new_data(new_data);
    last_optimization_ = drive_.nodes[solution.key_frames - 1].stamp;
    ++revision_;
    return poses();
  }

  KeyFramePoses poses() const { return poses_of(drive_, revision_); }
  KeyFramePoses odometry() const { return odometry_of(drive_, revision_); }
  pose_graph::PoseGraph graph() const { return pose_graph_of(drive_, config_); }

 private:
  /// Until the newest segment lies in East-North-Up, a solution is due after few positions.
  int gnss_optimization_step() const {
    // Positions; chosen: fewer solve more often while the graph is small.
    constexpr int kStepBeforeAlignment = 5;
    return segments_in_enu(drive_).back()
               ? config_.optimize_step_with_gnss
               : std::min(kStepBeforeAlignment, config_.optimize_step_with_gnss);
  }

  /// Small graphs are always solved completely. Large ones are solved completely after each growth
  /// by 5 %, and if a window was not sufficient for the new constraints.
  bool full_solve_due() const {
    // Key frames; chosen: more of them delay a solution, fewer give approximate poses earlier.
    constexpr std::size_t kSmallGraph = 4000;
    return full_solve_needed_ || drive_.nodes.size() < kSmallGraph ||
           20 * (drive_.nodes.size() - last_full_solve_) > drive_.nodes.size();
  }

  void apply_whole(const DriveGraph& solved, NewDataCounts& new_data) {
    apply_whole_solution(solved, drive_);
    new_data.loops = static_cast<int>(drive_.loops.size() - solved.loops.size());
    new_data.gnss = static_cast<int>(drive_.gnss.size() - solved.gnss.size());
    last_full_solve_ = solved.nodes.size();
    full_solve_needed_ = false;
  }

  void apply_window(const OptimizationSolution& solution, NewDataCounts& new_data) {
    full_solve_needed_ = solution.full_solve_needed;
    if (full_solve_needed_) return;
    apply_window_solution(solution.drive, *solution.window, solution.key_frames, drive_);
    const auto count_unevaluated = [](const auto& values) {
      return static_cast<int>(std::count_if(values.begin(), values.end(),
                                            [](const auto& value) { return !value.evaluated; }));
    };
    new_data.loops = count_unevaluated(drive_.loops);
    new_data.gnss = config_.georeference_only ? 0 : count_unevaluated(drive_.gnss);
  }

  BackEndConfig config_;
  GraphBuilder builder_;
  DriveGraph drive_;
  std::uint32_t revision_ = 0;
  Stamp last_optimization_ = 0;
  /// Number of key frames at the last solution of the whole graph.
  std::size_t last_full_solve_ = 0;
  bool full_solve_needed_ = false;
};

BackEnd::BackEnd(const BackEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
BackEnd::~BackEnd() = default;

void BackEnd::add_key_frame(const KeyFrame& key_frame) {
  impl_->builder().add_key_frame(key_frame, impl_->drive());
}
bool BackEnd::add_loop(const Loop& loop) { return impl_->builder().add_loop(loop, impl_->drive()); }
bool BackEnd::fits(const Loop& loop) const { return placed(loop, impl_->drive()).has_value(); }
void BackEnd::add_gnss(const GnssPosition& position) {
  impl_->builder().add_gnss(position, impl_->drive());
}
void BackEnd::add_imu(const ImuSample& sample_base) {
  impl_->builder().add_imu(sample_base, impl_->drive());
}
void BackEnd::add_floor(const Floor& floor) { impl_->builder().add_floor(floor, impl_->drive()); }
bool BackEnd::optimization_due() const { return impl_->optimization_due(); }
std::shared_ptr<const OptimizationProblem> BackEnd::problem(bool thorough) const {
  return impl_->problem(thorough);
}
KeyFramePoses BackEnd::apply(const OptimizationSolution& solution) {
  return impl_->apply(solution);
}
KeyFramePoses BackEnd::poses() const { return impl_->poses(); }
KeyFramePoses BackEnd::odometry() const { return impl_->odometry(); }
Pose BackEnd::T_map_odom() const { return impl_->drive().T_map_odom(); }
std::vector<std::pair<Loop, bool>> BackEnd::loops() const { return loops_of(impl_->drive()); }
std::vector<GnssPosition> BackEnd::positions() const { return positions_of(impl_->drive()); }
std::vector<int> BackEnd::parts() const { return parts_of(impl_->drive()); }
bool BackEnd::in_enu() const { return is_in_enu(impl_->drive()); }
pose_graph::PoseGraph BackEnd::graph() const { return impl_->graph(); }

}  // namespace lidar_mapping::back_end
