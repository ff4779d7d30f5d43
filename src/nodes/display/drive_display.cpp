// SPDX-License-Identifier: BSD-3-Clause
#include "display/drive_display.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/common/path_length.hpp"

#include "display/drive_status.hpp"
#include "display/path_display.hpp"
#include "worker_tasks.hpp"

namespace lidar_mapping::ros_border {

namespace {

const ros::WallDuration kInterval(1.0);
const ros::WallDuration kSilence(5.0);
constexpr double kFixDistance = 1.0;  // m, between positions on display; chosen: else they overlap
constexpr std::size_t kTasks = 20;    // new subscribers that wait; chosen: more than there are
constexpr std::uint32_t kQueue = 2;   // messages on their way; chosen: more would only be late

bool is_silent(const DriveView& view) {
  return !view.state.empty() && ros::WallTime::now() - view.newest_scan > kSilence;
}

}  // namespace

bool DriveView::add_fix(const Eigen::Vector3d& position) {
  if (!gnss.empty() && (position - gnss.back()).norm() < kFixDistance) return false;
  gnss.push_back(position);
  return true;
}

void DriveView::add_loop(KeyFrameIndex from, KeyFrameIndex to) {
  LoopVerdict verdict;
  verdict.from = from;
  verdict.to = to;
  loops.try_emplace({from, to}, verdict);
}

DriveDisplay::DriveDisplay(NodeContext& context, const NodeFields& fields,
                           std::function<const DriveView&()> view)
    : context_(context),
      fields_(fields),
      view_(std::move(view)),
      tasks_(context.worker.add_channel("display", kTasks)),
      odom_path_(advertise<nav_msgs::Path>(
          context, "odom_path", kQueue, tasks_, [this] { graph_changed(); }, true)),
      optimized_path_(advertise<nav_msgs::Path>(
          context, "optimized_path", kQueue, tasks_, [this] { graph_changed(); }, true)),
      graph_markers_(advertise<visualization_msgs::MarkerArray>(
          context, "graph_markers", kQueue, tasks_, [this] { show_all_markers(); })),
      timer_(do_at_intervals(context, "display refresh", kInterval.toSec(),
                             [this] { show_if_due(); })) {}

void DriveDisplay::graph_changed() {
  graph_outdated_ = paths_outdated_ = true;
  status_changed();
}

void DriveDisplay::status_changed() {
  markers_outdated_ = true;
  show_if_due();
}

/// Called by the timer as well, so that the last of many changes in a short time is displayed too.
void DriveDisplay::show_if_due() {
  if (is_silent(view_()) != was_silent_) markers_outdated_ = true;
  const ros::WallTime now = ros::WallTime::now();
  if (!markers_outdated_ || now - shown_at_ < kInterval) return;
  shown_at_ = now;
  if (paths_outdated_) show_paths();
  show_markers();
}

void DriveDisplay::show_paths() {
  paths_outdated_ = false;
  const map::KeyFrameTrack& track = view_().track;
  if (track.size() == 0) return;
  if (odom_path_.getNumSubscribers() > 0) {
    odom_path_.publish(to_path(track.odometry(), fields_.map_frame));
  }
  if (optimized_path_.getNumSubscribers() > 0) {
    optimized_path_.publish(to_path(track.poses(), fields_.map_frame));
  }
}

void DriveDisplay::show_markers() {
  markers_outdated_ = false;
  if (graph_markers_.getNumSubscribers() == 0) return;
  const visualization_msgs::MarkerArray changes = feed_.changes(markers());
  if (!changes.markers.empty()) graph_markers_.publish(changes);
  markers_outdated_ = feed_.has_more();
}

/// For a new subscriber.
void DriveDisplay::show_all_markers() { graph_markers_.publish(feed_.whole(markers())); }

MarkerFeed::Markers DriveDisplay::markers() {
  const DriveView& view = view_();
  if (std::exchange(graph_outdated_, false)) {
    graph_ = graph_markers(view.track, view.loops, view.candidates, fields_.map_frame);
    for (const MarkerFeed::Markers& more :
         {age_markers(view.track, fields_.map_frame),
          floor_markers(view.track, view.floors.below(), fields_.map_frame),
          gnss_markers(view.gnss, fields_.map_frame)}) {
      graph_.insert(graph_.end(), more.begin(), more.end());
    }
  }
  MarkerFeed::Markers all = graph_;
  all.push_back(status());
  return all;
}

visualization_msgs::Marker DriveDisplay::status() {
  const DriveView& view = view_();
  const KeyFramePoses poses = view.track.poses();
  was_silent_ = is_silent(view);
  DriveStatus status;
  status.state = view.state;
  status.silent = was_silent_;
  status.problem = view.problem;
  status.key_frames = poses.poses.size();
  if (view.optimized) {
    status.since_optimized = static_cast<std::size_t>(
        std::count_if(poses.poses.begin(), poses.poses.end(),
                      [&](const KeyFramePose& pose) { return pose.index > *view.optimized; }));
  }
  status.optimize_map = context_.node.resolveName("optimize_map");
  status.save_map = context_.node.resolveName("save_map");
  status.length = path_length(poses);
  for (const auto& [pair, loop] : view.loops) {
    ++(loop.verdict == Verdict::kRefused ? status.loops_refused : status.loops_used);
  }
  return status_text(status, fields_.map_frame, fields_.base_frame);
}

}  // namespace lidar_mapping::ros_border
