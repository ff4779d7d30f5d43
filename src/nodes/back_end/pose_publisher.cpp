// SPDX-License-Identifier: BSD-3-Clause
#include "back_end/pose_publisher.hpp"

#include <mutex>

#include <ros/single_subscriber_publisher.h>

#include "lidar_mapping/ros/mapping_conversions.hpp"

#include "back_end/sent_poses.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Messages that wait for a slow subscriber, which asks for all poses if one is dropped. Chosen:
/// more than a graph is solved in a second; some may have all poses, so it bounds the memory.
constexpr std::uint32_t kPosesQueue = 10;

}  // namespace

struct PosePublisher::State {
  explicit State(std::string frame) : map_frame(std::move(frame)) {}

  KeyFramePosesMessage message_of(const KeyFramePoses& poses) const {
    KeyFramePosesMessage message = to_message(poses, run_id, map_frame);
    message.thorough = static_cast<unsigned char>(thorough);
    return message;
  }

  const std::string map_frame;
  std::mutex mutex;  ///< of all below; messages are sent in the order of the changes
  std::string run_id;
  SentPoses sent;
  bool thorough = false;  ///< of the newest message
};

PosePublisher::PosePublisher(ros::NodeHandle& node, const std::string& map_frame)
    : state_(std::make_shared<State>(map_frame)) {
  const auto greet = [state = state_](const ros::SingleSubscriberPublisher& subscriber) {
    const std::lock_guard<std::mutex> lock(state->mutex);
    if (state->sent.all().poses.empty()) return;
    subscriber.publish(state->message_of(state->sent.all()));
  };
  publisher_ = node.advertise<KeyFramePosesMessage>("key_frame_poses", kPosesQueue, greet);
}

void PosePublisher::begin_run(const std::string& run_id) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->run_id = run_id;
  state_->sent.clear();
}

bool PosePublisher::publish(const KeyFramePoses& poses, bool thorough) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const auto news = state_->sent.update(poses, thorough);
  if (!news) return false;
  state_->thorough = thorough;
  publisher_.publish(state_->message_of(*news));
  return true;
}

}  // namespace lidar_mapping::ros_border
