// SPDX-License-Identifier: BSD-3-Clause
#include "pair_search.hpp"

#include <set>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"

namespace lidar_mapping::city {

namespace {

using loop_closing::LoopCloser;
using pipeline::SessionPart;
using session::Session;

/// Ranges with so many more key frames at both ends: submaps reach over the end of a range.
std::vector<KeyFrameRange> widened(std::vector<KeyFrameRange> ranges, KeyFrameIndex margin) {
  for (KeyFrameRange& range : ranges) {
    range.first -= std::min(range.first, margin);
    range.last += margin;
  }
  return ranges;
}

/// The clouds of both drives as far as the chunk needs them; those of drive b are numbered from
/// `first_of_b`.
class ChunkClouds : public CloudSource {
 public:
  ChunkClouds(const Session& a, const Session& b, const Chunk& chunk, KeyFrameIndex first_of_b,
              KeyFrameIndex margin)
      : a_(a.clouds()),
        b_(b.clouds()),
        a_ranges_(widened(chunk.a_ranges, margin)),
        b_ranges_(widened(chunk.b_ranges, margin)),
        first_of_b_(first_of_b) {}

  PointCloudPtr cloud(KeyFrameIndex index) override {
    if (index < first_of_b_) return contains(a_ranges_, index) ? a_.cloud(index) : nullptr;
    const KeyFrameIndex own = index - first_of_b_;
    return contains(b_ranges_, own) ? b_.cloud(own) : nullptr;
  }

 private:
  CloudSource& a_;
  CloudSource& b_;
  const std::vector<KeyFrameRange> a_ranges_;
  const std::vector<KeyFrameRange> b_ranges_;
  const KeyFrameIndex first_of_b_;
};

/// Where drive b begins in the graph of both.
pipeline::PartOffsets offsets_behind(const Session& a, const Session& b) {
  const std::vector<KeyFrame> key_frames_of_a = a.key_frames();
  pipeline::PartOffsets offsets = pipeline::offsets_behind(key_frames_of_a);
  std::set<Stamp> of_a, of_b;  // a search copies no records
  for (const KeyFrame& key_frame : key_frames_of_a) of_a.insert(key_frame.stamp);
  for (const KeyFrame& key_frame : b.key_frames()) of_b.insert(key_frame.stamp);
  offsets.stamp = pipeline::unique_stamp_offset(of_b, of_a);
  return offsets;
}

/// The part of a drive with positions in the frame of drive a; none if GNSS is left out.
SessionPart part_of(const Session& session, const pipeline::PartOffsets& offsets, const Session& a,
                    bool use_gnss) {
  const auto datum = use_gnss ? a.datum() : std::nullopt;
  return pipeline::read_part(session, offsets, pipeline::gnss_in_frame_of(datum, session));
}

class PairSearch {
 public:
  PairSearch(const Session& a, const Session& b, const Chunk& chunk, bool use_gnss,
             const back_end::BackEndConfig& back_end,
             const loop_closing::LoopClosingConfig& loop_closing,
             const std::filesystem::path& scratch)
      : chunk_(chunk),
        offsets_(offsets_behind(a, b)),
        a_(part_of(a, {}, a, use_gnss)),
        b_(part_of(b, offsets_, a, use_gnss)),
        clouds_(a, b, chunk, offsets_.index,
                static_cast<KeyFrameIndex>(loop_closing.extend_frame_num)),
        back_end_(back_end),
        closer_(loop_closing, clouds_, scratch) {
    if (const auto origin = a.sensor_origin()) closer_.set_sensor_origin(*origin);
    result_.a = chunk.a;
    result_.b = chunk.b;
    result_.used_gnss = !a_.gnss.empty() && !b_.gnss.empty();
  }

  PairLoops run() {
    for (const KeyFrame& key_frame : a_.key_frames) add_searched_in(key_frame);
    solve(true);
    closer_.search_only_before(offsets_.index);
    for (const KeyFrame& key_frame : b_.key_frames) add_searched_for(key_frame);
    return std::move(result_);
  }

 private:
  void add_searched_in(const KeyFrame& key_frame) {
    add_key_frame(a_, key_frame, back_end_, closer_);
    closer_.restore(key_frame);
    add_loops(a_, key_frame.index, back_end_, [&](const Loop& loop) {
      if (loop.decision != LoopDecision::kRefuse) closer_.add_loop(loop);
    });
  }

  void add_searched_for(const KeyFrame& key_frame) {
    const KeyFrameIndex own_index = key_frame.index - offsets_.index;
    if (own_index > chunk_.b_ranges.back().last) return;
    add_key_frame(b_, key_frame, back_end_, closer_);
    add_loops(b_, key_frame.index, back_end_, [](const Loop& /*known*/) {});
    if (contains(chunk_.b_ranges, own_index)) {
      search(key_frame);
    } else {
      closer_.restore(key_frame);
    }
    if (back_end_.optimization_due()) solve(false);
  }

  void search(const KeyFrame& key_frame) {
    ++result_.searched;
    const loop_closing::LoopClosingResult found = closer_.process(key_frame);
    for (LoopVerdict verdict : found.verdicts) {
      verdict.to -= offsets_.index;
      verdict.stamp -= offsets_.stamp;
      result_.verdicts.push_back(verdict);
    }
    for (Loop loop : found.loops) {
      back_end_.add_loop(loop);
      loop.to -= offsets_.index;
      loop.stamp -= offsets_.stamp;
      result_.loops.push_back(loop);
    }
  }

  void solve(bool thorough) {
    const auto solution = back_end::solve(*back_end_.problem(thorough));
    closer_.update_poses(back_end_.apply(*solution));
  }

  const Chunk chunk_;
  const pipeline::PartOffsets offsets_;
  const SessionPart a_;
  const SessionPart b_;
  ChunkClouds clouds_;
  back_end::BackEnd back_end_;
  LoopCloser closer_;
  PairLoops result_;
};

}  // namespace

PairLoops search_chunk(const Session& a, const Session& b, const Chunk& chunk,
                       const back_end::BackEndConfig& back_end,
                       const loop_closing::LoopClosingConfig& loop_closing,
                       const std::filesystem::path& scratch) {
  if (chunk.a_ranges.empty() || chunk.b_ranges.empty()) return {chunk.a, chunk.b, false, 0, {}, {}};
  PairLoops placed = PairSearch(a, b, chunk, true, back_end, loop_closing, scratch).run();
  if (!placed.used_gnss || !placed.loops.empty() || !chunk.by_appearance) return placed;
  PairLoops free = PairSearch(a, b, chunk, false, back_end, loop_closing, scratch).run();
  return free.loops.empty() ? placed : free;
}

}  // namespace lidar_mapping::city
