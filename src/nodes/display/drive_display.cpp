// SPDX-License-Identifier: BSD-3-Clause
#include "display/drive_display.hpp"

#include <algorithm>

#include "lidar_mapping/common/path_length.hpp"

#include "display/path_display.hpp"
#include "worker_tasks.hpp"

namespace lidar_mapping::ros_border {

namespace {

const ros::WallDuration kStatusInterval(1.0);
const ros::WallDuration kSilence(5.0);
constexpr double kFixDistance = 1.0;  // m, between positions on display; chosen: else they overlap
constexpr std::size_t kTasks = 20;    // new subscribers that wait; chosen: more than there are
constexpr std::uint32_t kQueue = 2;   // messages on their way; chosen: more would only be late

double now() { return ros::WallTime::now().toSec(); }

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
      timer_(do_at_intervals(context, "display refresh", kStatusInterval.toSec(),
                             [this] { show_if_due(); })) {}

void DriveDisplay::graph_changed() {
  graph_outdated_ = true;
  show_if_due();
}

void DriveDisplay::status_changed() {
  status_outdated_ = true;
  show_if_due();
}

/// Called by the timer as well, so that the last of many changes in a short time is displayed too.
void DriveDisplay::show_if_due() {
  const double begin = now();
  if (graph_outdated_ && graph_pace_.is_due(begin)) {
    graph_outdated_ = false;
    show_paths();
    if (graph_markers_.getNumSubscribers() > 0) {
      draw_graph();
      show_graph();
    }
    graph_pace_.drawn(begin, now());
  }
  if (is_silent(view_()) != was_silent_) status_outdated_ = true;
  if (status_outdated_ && ros::WallTime::now() - status_shown_at_ >= kStatusInterval) show_status();
}

void DriveDisplay::show_paths() {
  const map::KeyFrameTrack& track = view_().track;
  if (track.size() == 0) return;
  if (odom_path_.getNumSubscribers() > 0) {
    odom_path_.publish(to_path(track.odometry(), fields_.map_frame));
  }
  if (optimized_path_.getNumSubscribers() > 0) {
    optimized_path_.publish(to_path(track.poses(), fields_.map_frame));
  }
}

void DriveDisplay::draw_graph() {
  const DriveView& view = view_();
  graph_ = graph_markers(view.track, view.loops, view.candidates, fields_.map_frame);
  for (const MarkerFeed::Markers& more :
       {age_markers(view.track, fields_.map_frame),
        floor_markers(view.track, view.floors.below(), fields_.map_frame),
        gnss_markers(view.gnss, fields_.map_frame)}) {
    graph_.insert(graph_.end(), more.begin(), more.end());
  }
  const KeyFramePoses poses = view.track.poses();
  status_.key_frames = poses.poses.size();
  if (view.optimized) {
    status_.since_optimized = static_cast<std::size_t>(
        std::count_if(poses.poses.begin(), poses.poses.end(),
                      [&](const KeyFramePose& pose) { return pose.index > *view.optimized; }));
  } else {
    status_.since_optimized.reset();
  }
  status_.length = path_length(poses);
  status_.loops_used = status_.loops_refused = 0;
  for (const auto& [pair, loop] : view.loops) {
    ++(loop.verdict == Verdict::kRefused ? status_.loops_refused : status_.loops_used);
  }
  status_outdated_ = true;
}

void DriveDisplay::show_graph() {
  const visualization_msgs::MarkerArray changes = graph_feed_.changes(graph_);
  if (!changes.markers.empty()) graph_markers_.publish(changes);
  if (graph_feed_.has_more()) graph_outdated_ = true;
}

void DriveDisplay::show_status() {
  status_outdated_ = false;
  status_shown_at_ = ros::WallTime::now();
  if (graph_markers_.getNumSubscribers() == 0) return;
  const visualization_msgs::MarkerArray changes = status_feed_.changes({status_marker()});
  if (!changes.markers.empty()) graph_markers_.publish(changes);
}

/// For a new subscriber.
void DriveDisplay::show_all_markers() {
  draw_graph();
  visualization_msgs::MarkerArray message = graph_feed_.whole(graph_);
  message.markers.push_back(status_marker());
  status_feed_.changes({message.markers.back()});
  graph_markers_.publish(message);
}

visualization_msgs::Marker DriveDisplay::status_marker() {
  const DriveView& view = view_();
  was_silent_ = is_silent(view);
  status_.state = view.state;
  status_.silent = was_silent_;
  status_.problem = view.problem;
  status_.optimize_map = context_.node.resolveName("optimize_map");
  status_.save_map = context_.node.resolveName("save_map");
  return status_text(status_, fields_.map_frame, fields_.base_frame);
}

}  // namespace lidar_mapping::ros_border
