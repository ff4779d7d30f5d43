// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/key_frame_feed.hpp"

#include <algorithm>
#include <utility>

namespace lidar_mapping::ros_border {

namespace {

/// Number of key frames in a request. Chosen: limits the size of an answer, because a key frame of
/// 64 beams has about a megabyte.
constexpr std::size_t kChunk = 10;
/// A missing key frame is skipped after this number of newer ones. Chosen: an answer to the request
/// for it comes sooner.
constexpr std::size_t kMaxNewerPending = 5;

std::vector<std::vector<KeyFrameIndex>> chunks_of(const std::vector<KeyFrameIndex>& indices) {
  std::vector<std::vector<KeyFrameIndex>> chunks;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (i % kChunk == 0) chunks.emplace_back();
    chunks.back().push_back(indices[i]);
  }
  return chunks;
}

}  // namespace

KeyFrameFeed::KeyFrameFeed(Fetch fetch, Deliver deliver, Begin begin)
    : fetch_(std::move(fetch)), deliver_(std::move(deliver)), begin_(std::move(begin)) {}

void KeyFrameFeed::push(ReceivedKeyFrame key_frame) {
  if (key_frame.run_id != run_id_) begin_run(key_frame.run_id);
  const KeyFrameIndex index = key_frame.key_frame.index;
  if (index < next_) return;
  pending_.emplace(index, std::move(key_frame));
  deliver_pending();
  fetch_gap();
  while (pending_.size() > kMaxNewerPending) skip_missing();
}

void KeyFrameFeed::flush() {
  while (!pending_.empty()) skip_missing();
}

void KeyFrameFeed::skip_missing() {
  missing_ += pending_.begin()->first - next_;
  deliver_first();
  deliver_pending();
}

void KeyFrameFeed::catch_up(const RunIndices& known) {
  if (known.run_id != run_id_) begin_run(known.run_id);
  std::vector<KeyFrameIndex> wanted;
  for (const KeyFrameIndex index : known.indices) {
    if (index >= next_) wanted.push_back(index);
  }
  for (const auto& chunk : chunks_of(wanted)) {
    fetch(chunk);
    // Indices that the back end does not have are skipped.
    while (!pending_.empty() && pending_.begin()->first <= chunk.back()) deliver_first();
  }
  deliver_pending();
}

bool KeyFrameFeed::would_skip(const RunIndices& some) const {
  if (some.whole || some.indices.empty()) return false;
  const KeyFrameIndex next = some.run_id == run_id_ ? next_ : 0;
  if (some.indices.back() < next) return false;
  const auto begin = std::lower_bound(some.indices.begin(), some.indices.end(), next);
  const auto listed = static_cast<std::size_t>(some.indices.end() - begin);
  return listed <= some.indices.back() - next;
}

void KeyFrameFeed::begin_run(const std::string& run_id) {
  flush();  // what waits belongs to the run before
  next_ = begin_(run_id);
  run_id_ = run_id;
}

void KeyFrameFeed::fetch_gap() {
  if (pending_.empty()) return;
  std::vector<KeyFrameIndex> gap;
  for (KeyFrameIndex index = next_; index < pending_.begin()->first; ++index) gap.push_back(index);
  for (const auto& chunk : chunks_of(gap)) {
    fetch(chunk);
    deliver_pending();
  }
}

void KeyFrameFeed::fetch(const std::vector<KeyFrameIndex>& indices) {
  for (ReceivedKeyFrame& found : fetch_(indices)) {
    const KeyFrameIndex index = found.key_frame.index;
    if (found.run_id == run_id_ && index >= next_) pending_.emplace(index, std::move(found));
  }
}

void KeyFrameFeed::deliver_pending() {
  while (!pending_.empty() && pending_.begin()->first == next_) deliver_first();
}

void KeyFrameFeed::deliver_first() {
  const auto node = pending_.extract(pending_.begin());
  next_ = node.key() + 1;
  deliver_(node.mapped());
}

}  // namespace lidar_mapping::ros_border
