// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/merge.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include "datum.hpp"

namespace lidar_mapping::pipeline {

namespace {

using loop_closing::LoopCloser;
using session::Session;

/// The least shift (ns) by which no stamp of the part is known yet.
Stamp free_shift(const std::vector<KeyFrame>& part, const std::set<Stamp>& known) {
  Stamp shift = 0;
  const auto is_known = [&](const KeyFrame& key_frame) {
    return known.count(key_frame.stamp + shift) > 0;
  };
  while (std::any_of(part.begin(), part.end(), is_known)) ++shift;
  return shift;
}

template <typename Value>
std::map<Stamp, Value> by_stamp(const std::vector<Value>& values) {
  std::map<Stamp, Value> result;
  for (const Value& value : values) result.emplace(value.stamp, value);
  return result;
}

/// Calls `take` with the value of that stamp, if there is one.
template <typename Value, typename Take>
void give(const std::map<Stamp, Value>& values, Stamp stamp, Stamp shift, const Take& take) {
  const auto found = values.find(stamp);
  if (found == values.end()) return;
  Value value = found->second;
  value.stamp += shift;
  take(value);
}

/// Where a part comes to lie in the joined session.
struct Offsets {
  KeyFrameIndex index = 0;
  std::uint32_t segment = 0;
  Stamp shift = 0;
};

Loop moved(Loop loop, const Offsets& offsets) {
  loop.from += offsets.index;
  loop.to += offsets.index;
  loop.stamp += offsets.shift;
  return loop;
}

LoopVerdict moved(LoopVerdict verdict, const Offsets& offsets) {
  verdict.from += offsets.index;
  verdict.to += offsets.index;
  verdict.stamp += offsets.shift;
  return verdict;
}

}  // namespace

class Merge::Impl {
 public:
  Impl(Session out, const back_end::BackEndConfig& back_end,
       const loop_closing::LoopClosingConfig& loop_closing)
      : back_end_(std::move(out), back_end),
        closer_(loop_closing, session().clouds(), session().directory()) {}

  void add(const Session& part);
  void finish();
  const std::vector<MergedPart>& parts() const { return parts_; }

 private:
  struct Measurements {
    std::map<Stamp, GnssPosition> gnss;
    std::map<Stamp, ImuSample> imu;
    std::map<Stamp, Floor> floors;
    std::multimap<KeyFrameIndex, Loop> loops;  ///< by their newer end
  };

  Session& session() { return back_end_.session(); }
  void take_settings(const Session& part);
  std::vector<GnssPosition> gnss_of(const Session& part, MergedPart& merged);
  Measurements measurements_of(const Session& part, MergedPart& merged);
  void copy_records(const Session& part, const Offsets& offsets);
  void add_key_frame(KeyFrame key_frame, const Session& part, const Measurements& measurements,
                     const Offsets& offsets, MergedPart& merged);
  void add_own_loop(const Loop& loop);
  void search(const KeyFrame& key_frame, MergedPart& merged);
  void solve(bool thorough);

  RecordedBackEnd back_end_;
  LoopCloser closer_;
  std::vector<MergedPart> parts_;
  std::set<Stamp> stamps_;
  std::set<std::pair<KeyFrameIndex, KeyFrameIndex>> pairs_;
  Offsets next_;
};

/// What is said once for the whole session comes from the first part.
void Merge::Impl::take_settings(const Session& part) {
  for (const auto& [stage, yaml] : part.configurations()) session().set_configuration(stage, yaml);
  const auto origin = part.sensor_origin();
  if (!origin) return;
  session().set_sensor_origin(*origin);
  closer_.set_sensor_origin(*origin);
}

/// In the East-North-Up frame of the joined session.
std::vector<GnssPosition> Merge::Impl::gnss_of(const Session& part, MergedPart& merged) {
  std::vector<GnssPosition> positions = part.gnss();
  if (positions.empty()) return positions;
  const auto datum = part.datum();
  if (!datum && parts_.empty()) return positions;
  if (!datum) {
    merged.notices.push_back(part.directory().string() +
                             " does not know the datum of its GNSS positions; they are left out");
    return {};
  }
  if (!session().datum()) {
    if (!session().gnss().empty()) {
      merged.notices.push_back("the sessions before " + part.directory().string() +
                               " do not know the datum of their GNSS positions, so those of this "
                               "one are left out; name the sessions with a datum first");
      return {};
    }
    session().set_datum(*datum);
  }
  const Pose T_new_old = enu_between(*session().datum(), *datum);
  for (GnssPosition& position : positions) position = turned(position, T_new_old);
  return positions;
}

Merge::Impl::Measurements Merge::Impl::measurements_of(const Session& part, MergedPart& merged) {
  Measurements result;
  result.gnss = by_stamp(gnss_of(part, merged));
  result.imu = by_stamp(part.imu());
  result.floors = by_stamp(part.floors());
  for (const Loop& loop : part.loops()) result.loops.emplace(std::max(loop.from, loop.to), loop);
  return result;
}

/// What the graph does not need: for the report.
void Merge::Impl::copy_records(const Session& part, const Offsets& offsets) {
  Session::Batch batch(session());
  for (session::ScanRecord scan : part.scans()) {
    scan.stamp += offsets.shift;
    session().add_scan(scan);
  }
  for (const auto& [stamp, pose] : part.odometry()) {
    session().add_odometry(stamp + offsets.shift, pose);
  }
  for (const LoopVerdict& verdict : part.verdicts()) {
    session().add_verdict(moved(verdict, offsets));
  }
  batch.commit();
}

void Merge::Impl::add(const Session& part) {
  if (parts_.empty()) take_settings(part);
  MergedPart merged;
  const std::vector<KeyFrame> key_frames = part.key_frames();
  const Measurements measurements = measurements_of(part, merged);
  Offsets offsets = next_;
  offsets.shift = free_shift(key_frames, stamps_);
  merged.first = key_frames.empty() ? offsets.index : offsets.index + key_frames.front().index;
  merged.key_frames = key_frames.size();
  merged.shift = offsets.shift;
  copy_records(part, offsets);
  for (const KeyFrame& key_frame : key_frames) {
    add_key_frame(key_frame, part, measurements, offsets, merged);
  }
  solve(true);
  parts_.push_back(merged);
}

void Merge::Impl::add_key_frame(KeyFrame key_frame, const Session& part,
                                const Measurements& measurements, const Offsets& offsets,
                                MergedPart& merged) {
  const KeyFrameIndex own_index = key_frame.index;
  const Stamp own_stamp = key_frame.stamp;
  key_frame.cloud = part.clouds().cloud(own_index);
  key_frame.index += offsets.index;
  key_frame.segment += offsets.segment;
  key_frame.stamp += offsets.shift;
  back_end_.add_key_frame(key_frame);
  stamps_.insert(key_frame.stamp);
  next_.index = key_frame.index + 1;
  next_.segment = key_frame.segment + 1;
  give(measurements.gnss, own_stamp, offsets.shift, [&](const GnssPosition& position) {
    back_end_.add_gnss(position);
    closer_.add_gnss(position);
  });
  give(measurements.imu, own_stamp, offsets.shift,
       [&](const ImuSample& sample) { back_end_.add_imu(sample); });
  give(measurements.floors, own_stamp, offsets.shift,
       [&](const Floor& floor) { back_end_.add_floor(floor); });
  // The first drive has been searched already.
  if (parts_.empty()) {
    closer_.restore(key_frame);
  } else {
    search(key_frame, merged);
  }
  const auto [begin, end] = measurements.loops.equal_range(own_index);
  for (auto loop = begin; loop != end; ++loop) add_own_loop(moved(loop->second, offsets));
  if (!parts_.empty() && back_end_.optimization_due()) solve(false);
}

void Merge::Impl::add_own_loop(const Loop& loop) {
  if (!back_end_.add_loop(loop)) return;
  if (loop.decision != LoopDecision::kAuto) {
    session().set_loop_decision(loop.from, loop.to, loop.decision);
  }
  if (loop.decision != LoopDecision::kRefuse) closer_.add_loop(loop);
  pairs_.emplace(loop.from, loop.to);
}

void Merge::Impl::search(const KeyFrame& key_frame, MergedPart& merged) {
  const loop_closing::LoopClosingResult found = closer_.process(key_frame);
  for (const LoopVerdict& verdict : found.verdicts) session().add_verdict(verdict);
  for (const Loop& loop : found.loops) {
    if (!pairs_.emplace(loop.from, loop.to).second) continue;
    if (back_end_.add_loop(loop)) ++merged.new_loops;
  }
}

void Merge::Impl::solve(bool thorough) {
  const auto solution = back_end::solve(*back_end_.problem(thorough));
  closer_.update_poses(back_end_.apply(*solution, 0.0).poses);
}

void Merge::Impl::finish() {
  solve(true);
  back_end_.write_files();
  std::map<KeyFrameIndex, int> part_of;
  const KeyFramePoses poses = back_end_.poses();
  const std::vector<int> all = back_end_.parts();
  for (std::size_t i = 0; i < all.size(); ++i) part_of[poses.poses[i].index] = all[i];
  std::set<int> first;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    std::set<int> own;
    const bool last = p + 1 == parts_.size();
    const auto end = last ? part_of.end() : part_of.lower_bound(parts_[p + 1].first);
    for (auto it = part_of.lower_bound(parts_[p].first); it != end; ++it) own.insert(it->second);
    if (p == 0) first = own;
    parts_[p].joined =
        std::any_of(own.begin(), own.end(), [&](int part) { return first.count(part) > 0; });
  }
}

Merge::Merge(Session out, const back_end::BackEndConfig& back_end,
             const loop_closing::LoopClosingConfig& loop_closing)
    : impl_(std::make_unique<Impl>(std::move(out), back_end, loop_closing)) {}
Merge::~Merge() = default;

void Merge::add(const Session& part) { impl_->add(part); }
void Merge::finish() { impl_->finish(); }
const std::vector<MergedPart>& Merge::parts() const { return impl_->parts(); }

}  // namespace lidar_mapping::pipeline
