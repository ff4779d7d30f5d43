// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/key_frame_client.hpp"

#include <algorithm>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/mapping_conversions.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

namespace lidar_mapping::ros_border {

namespace {

const char* const kService = "get_key_frames";
/// Number of fetched key frames that is not logged: poses may arrive before the key frame that they
/// belong to.
constexpr KeyFrameIndex kOvertaken = 1;
/// Time in which a killed back end has been restarted, if it is restarted at all, s. Chosen:
/// roslaunch restarts it at once, and a long session is read within seconds.
constexpr double kRestartTime = 15.0;

}  // namespace

RunIndices RunState::indices() const {
  RunIndices result{run_id, {}};
  for (const KeyFrame& key_frame : key_frames) result.indices.push_back(key_frame.index);
  return result;
}

KeyFrameClient::KeyFrameClient(const ros::NodeHandle& node) : node_(node) {}

std::optional<RunState> KeyFrameClient::run() {
  const auto response = call({}, false);
  if (!response) return std::nullopt;
  RunState state;
  state.run_id = response->poses.run_id;
  state.poses = from_message(response->poses);
  for (const KeyFrameMessage& message : response->key_frames) {
    state.key_frames.push_back(from_message(message));
    if (state.run_id.empty()) state.run_id = message.run_id;
  }
  std::sort(state.key_frames.begin(), state.key_frames.end(),
            [](const KeyFrame& a, const KeyFrame& b) { return a.index < b.index; });
  for (const LoopMessage& message : response->loops) state.loops.push_back(from_message(message));
  if (response->antennas.size() != response->gnss.size()) {
    throw InputError("get_key_frames: gnss and antennas differ in number");
  }
  for (std::size_t i = 0; i < response->gnss.size(); ++i) {
    state.gnss.push_back(from_message(response->gnss[i], from_message(response->antennas[i])));
  }
  for (const FloorMessage& message : response->floors) {
    state.floors.push_back(from_message(message));
  }
  state.searched = response->searched;
  return state;
}

std::optional<RunState> KeyFrameClient::wait_for_run() {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kRestartTime);
  const std::string service = node_.resolveName(kService);
  while (ros::ok() && !ros::service::exists(service, false)) {
    if (node_.hasParam(kRunResuming)) {
      ROS_INFO_ONCE("waiting for back_end_node, which reads the session that this drive goes on");
    } else if (!node_.hasParam(kRunSession) || ros::WallTime::now() > end) {
      break;
    }
    ros::WallDuration(0.1).sleep();
  }
  return run();
}

std::optional<RunPoses> KeyFrameClient::poses() {
  // Any answer has all poses. One key frame is asked for, because an empty list would mean all.
  const auto response = call({KeyFrameIndex{0}}, false);
  if (!response || response->poses.run_id.empty()) return std::nullopt;
  return RunPoses{response->poses.run_id, from_message(response->poses)};
}

std::vector<ReceivedKeyFrame> KeyFrameClient::fetch(const std::vector<KeyFrameIndex>& indices) {
  std::vector<ReceivedKeyFrame> result;
  if (indices.empty()) return result;  // an empty list would mean all
  const auto response = call(indices, true);
  if (!response) return result;
  for (const KeyFrameMessage& message : response->key_frames) {
    result.push_back(received(message));
  }
  return result;
}

std::optional<GetKeyFrames::Response> KeyFrameClient::call(
    const std::vector<KeyFrameIndex>& indices, bool clouds) {
  const std::string service = node_.resolveName(kService);
  GetKeyFrames request;
  request.request.indices = indices;
  request.request.clouds = clouds;
  if (!ros::service::exists(service, false) || !ros::service::call(service, request)) {
    return std::nullopt;
  }
  return std::move(request.response);
}

KeyFrameSubscription::KeyFrameSubscription(NodeContext& context, int capacity,
                                           KeyFrameFeed::Deliver deliver)
    : client_(context.node),
      feed_([this](const auto& indices) { return client_.fetch(indices); }, std::move(deliver)) {
  context.worker.post(context.worker.add_channel("catch_up", 1), [this] { catch_up(); });
  subscriber_ = subscribe<KeyFrameMessage>(context, "key_frame", capacity,
                                           [this](const auto& m) { feed_.push(received(*m)); });
}

void KeyFrameSubscription::catch_up() {
  const auto state = client_.run();
  if (state) note(state->indices());
}

void KeyFrameSubscription::note(RunIndices known) {
  // The front end may have begun a run that the back end does not know yet.
  const bool other_run = !feed_.run_id().empty() && feed_.run_id() != known.run_id;
  if (known.indices.empty() || other_run) return;
  std::sort(known.indices.begin(), known.indices.end());
  if (feed_.would_skip(known)) return catch_up();
  const KeyFrameIndex before = feed_.next_index();
  feed_.catch_up(known);
  if (feed_.next_index() > before + kOvertaken) {
    ROS_INFO_STREAM("caught up: key frames " << before << " to " << feed_.next_index() - 1
                                             << " from the back end");
  }
}

}  // namespace lidar_mapping::ros_border
