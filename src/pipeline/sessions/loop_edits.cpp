// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/loop_edits.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/loop_closing/pair_match.hpp"

namespace lidar_mapping::pipeline {

namespace {

template <typename Loops>
auto find_loop(Loops& loops, KeyFrameIndex from, KeyFrameIndex to) {
  return std::find_if(loops.begin(), loops.end(), [&](const Loop& loop) {
    return std::min(loop.from, loop.to) == from && std::max(loop.from, loop.to) == to;
  });
}

std::string pair_text(const session::LoopEdit& edit) {
  return std::to_string(edit.from) + " and " + std::to_string(edit.to);
}

Loop known_loop(const std::vector<Loop>& loops, const session::LoopEdit& edit) {
  const auto found = find_loop(loops, edit.from, edit.to);
  if (found != loops.end()) return *found;
  throw InputError(edit.where + ": there is no loop between key frames " + pair_text(edit) +
                   "; loops.txt of the session lists them, and 'add' makes a new one");
}

/// Of several lines on a pair the last one, whether or not the session agrees with it already.
std::vector<session::LoopEdit> last_of_each_pair(const std::vector<session::LoopEdit>& edits) {
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, std::size_t> places;
  std::vector<session::LoopEdit> result;
  for (const session::LoopEdit& edit : edits) {
    const auto [place, is_new] = places.try_emplace({edit.from, edit.to}, result.size());
    if (is_new) result.emplace_back();
    result[place->second] = edit;
  }
  return result;
}

class PairMatcher {
 public:
  PairMatcher(const session::Session& session, const loop_closing::LoopClosingConfig& config)
      : config_(config),
        clouds_(session.clouds()),
        p_base_lidar_(session.sensor_origin().value_or(Eigen::Vector3d::Zero())),
        key_frames_(session.key_frames()) {}

  Loop match(const session::LoopEdit& edit) const {
    const loop_closing::PairMatch match = match_or_throw(edit);
    if (match.loop) return *match.loop;
    throw InputError(edit.where + ": key frames " + pair_text(edit) +
                     " do not match: " + match.verdict.reason +
                     "; give a better guess of the pose of the second in the first (X Y Z ROLL "
                     "PITCH YAW), or leave the line out");
  }

 private:
  loop_closing::PairMatch match_or_throw(const session::LoopEdit& edit) const {
    try {
      return loop_closing::match_pair(config_, clouds_, p_base_lidar_, key_frames_, edit.from,
                                      edit.to, edit.guess);
    } catch (const InputError& error) {
      throw InputError(edit.where + ": " + error.what());
    }
  }

  const loop_closing::LoopClosingConfig config_;
  session::CloudStore& clouds_;
  const Eigen::Vector3d p_base_lidar_;
  const std::vector<KeyFrame> key_frames_;
};

}  // namespace

std::vector<Loop> edited_loops(const session::Session& session,
                               const std::vector<session::LoopEdit>& edits,
                               const loop_closing::LoopClosingConfig& config) {
  const std::vector<Loop> known = session.loops();
  const PairMatcher matcher(session, config);
  std::vector<Loop> edited;
  for (const session::LoopEdit& edit : last_of_each_pair(edits)) {
    Loop loop = edit.add ? matcher.match(edit) : known_loop(known, edit);
    if (!edit.add && loop.decision == edit.decision) continue;
    loop.decision = edit.decision;
    edited.push_back(loop);
  }
  return edited;
}

std::vector<Loop> replace_loops(std::vector<Loop> loops, const std::vector<Loop>& edited) {
  for (const Loop& loop : edited) {
    const auto found = find_loop(loops, std::min(loop.from, loop.to), std::max(loop.from, loop.to));
    if (found != loops.end()) {
      *found = loop;
    } else {
      loops.push_back(loop);
    }
  }
  return loops;
}

void store_decisions(session::Session& session, const std::vector<Loop>& edited) {
  for (const Loop& loop : edited) {
    session.add_loop(loop);
    session.set_loop_decision(loop.from, loop.to, loop.decision);
  }
}

}  // namespace lidar_mapping::pipeline
