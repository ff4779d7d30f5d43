// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/pose_feed.hpp"

#include <utility>

namespace lidar_mapping::ros_border {

RunIndices RunPoses::indices() const {
  RunIndices result{run_id, {}, poses.whole};
  for (const KeyFramePose& pose : poses.poses) result.indices.push_back(pose.index);
  return result;
}

PoseFeed::PoseFeed(Fetch fetch) : fetch_(std::move(fetch)) {}

std::optional<RunPoses> PoseFeed::push(const RunPoses& received) {
  const KeyFramePoses& poses = received.poses;
  const bool is_known = received.run_id == run_id_ && poses.revision <= revision_;
  if (!poses.whole && complete_ && is_known) return std::nullopt;
  std::optional<RunPoses> all;
  if (!poses.whole && !continues(received)) all = fetched_instead_of(received);
  const RunPoses& news = all ? *all : received;
  take(news);
  return news;
}

KeyFramePoses PoseFeed::known(const std::string& run_id) const {
  KeyFramePoses result;
  if (run_id != run_id_) return result;
  result.revision = revision_;
  for (const auto& [index, pose] : poses_) result.poses.push_back(pose);
  return result;
}

bool PoseFeed::continues(const RunPoses& received) const {
  return complete_ && received.run_id == run_id_ && received.poses.since <= revision_;
}

/// Nothing if the answer is older than what was received, or not whole.
std::optional<RunPoses> PoseFeed::fetched_instead_of(const RunPoses& received) const {
  std::optional<RunPoses> all = fetch_();
  if (!all || !all->poses.whole) return std::nullopt;
  const bool is_older =
      all->run_id == received.run_id && all->poses.revision < received.poses.revision;
  if (is_older) return std::nullopt;
  return all;
}

void PoseFeed::take(const RunPoses& news) {
  const bool continued = news.poses.whole || continues(news);
  if (news.poses.whole || news.run_id != run_id_) poses_.clear();
  complete_ = continued;
  run_id_ = news.run_id;
  revision_ = news.poses.revision;
  for (const KeyFramePose& pose : news.poses.poses) poses_[pose.index] = pose;
}

}  // namespace lidar_mapping::ros_border
