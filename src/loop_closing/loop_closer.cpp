// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/loop_closer.hpp"

#include <algorithm>
#include <set>

#include "decision/segment_connector.hpp"
#include "decision/verified_candidate.hpp"
#include "matching/scan_alignment.hpp"
#include "matching/submap_builder.hpp"
#include "sight.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Metres of path length between two candidates that are both matched. Chosen: within less they see
// nearly the same surroundings.
constexpr double kMinCandidateSpacing = 10.0;

}  // namespace

class LoopCloser::Impl {
 public:
  Impl(const LoopClosingConfig& config, CloudSource& clouds, const std::filesystem::path& directory)
      : config_(config),
        alignment_(config),
        submaps_(config, clouds),
        generator_(config, directory),
        connector_(config.unanchored_path_length) {}

  void set_sensor_origin(const Eigen::Vector3d& p_base_lidar) {
    submaps_.set_sensor_origin(p_base_lidar);
  }
  void search_only_before(KeyFrameIndex end) { generator_.search_only_before(end); }
  void update_poses(const KeyFramePoses& poses) { generator_.update_poses(poses); }
  void add_gnss(const GnssPosition& position) { generator_.add_gnss(position); }

  void add(const KeyFrame& key_frame, const PreparedKeyFrame& prepared);
  void add(const Loop& loop);
  LoopClosingResult process(const KeyFrame& key_frame, const PreparedKeyFrame& prepared);

 private:
  using NodeId = Trajectory::NodeId;

  const Trajectory& trajectory() const { return generator_.trajectory(); }
  void note_loop_at(NodeId to);
  bool is_due() const;
  std::vector<Candidate> selected_candidates() const;
  std::optional<VerifiedCandidate> refused_by_views(const Candidate& candidate);
  VerifiedCandidate matched(const Candidate& candidate);
  std::vector<VerifiedCandidate> verify_candidates();
  void add_accepted(const VerifiedCandidate& verified, LoopClosingResult& result);

  LoopClosingConfig config_;
  ScanAlignment alignment_;
  SubmapBuilder submaps_;
  CandidateGenerator generator_;
  SegmentConnector connector_;
  // Of the newest key frame; made when the first candidate of a search needs them.
  std::shared_ptr<const SingleView> view_;
  std::optional<QueryScan> query_;
  int key_frames_since_search_ = 0;
  std::optional<double> last_loop_travelled_;
  // Newer key frames of loops that were restored before these: those are searched again.
  std::set<KeyFrameIndex> early_loop_ends_;
};

void LoopCloser::Impl::add(const KeyFrame& key_frame, const PreparedKeyFrame& prepared) {
  const PointsPtr scan = submaps_.add_newest(key_frame, prepared.points);
  std::optional<Appearance> appearance = prepared.appearance;
  if (scan && !appearance) appearance = appearance_of(*scan);
  generator_.append(key_frame, appearance);
  ++key_frames_since_search_;
  if (early_loop_ends_.erase(key_frame.index) > 0) note_loop_at(trajectory().size() - 1);
}

void LoopCloser::Impl::add(const Loop& loop) {
  generator_.add_loop(loop);
  const auto to = trajectory().find(loop.to);
  if (to) {
    note_loop_at(*to);
  } else {
    early_loop_ends_.insert(loop.to);
  }
}

void LoopCloser::Impl::note_loop_at(NodeId to) {
  last_loop_travelled_ = std::max(last_loop_travelled_.value_or(0.0), trajectory()[to].travelled);
}

bool LoopCloser::Impl::is_due() const {
  if (key_frames_since_search_ < config_.loop_step) return false;
  if (!last_loop_travelled_) return true;
  const double travelled = trajectory()[trajectory().size() - 1].travelled;
  return travelled - *last_loop_travelled_ >= search_interval(generator_.sight(), config_);
}

/// The best candidates, at different locations if possible: neighbouring ones would succeed or fail
/// together.
std::vector<Candidate> LoopCloser::Impl::selected_candidates() const {
  std::vector<Candidate> result;
  for (const Candidate& candidate : generator_.candidates()) {
    const auto is_near = [&](const Candidate& other) {
      return trajectory().path_length_between(candidate.node, other.node) < kMinCandidateSpacing;
    };
    if (std::any_of(result.begin(), result.end(), is_near)) continue;
    result.push_back(candidate);
    if (result.size() == static_cast<std::size_t>(config_.max_registrations)) break;
  }
  return result;
}

/// The cheap test: the two key frames alone, at the starting pose. Where the estimate admits other
/// places most candidates are such, and nothing else is computed for these.
std::optional<VerifiedCandidate> LoopCloser::Impl::refused_by_views(const Candidate& candidate) {
  if (!admits_other_places(candidate.prior)) return std::nullopt;
  if (!view_) view_ = submaps_.view_of(trajectory()[trajectory().size() - 1].index);
  const auto older = submaps_.view_of(trajectory()[candidate.node].index);
  if (!view_ || !older) return std::nullopt;
  const double violation = free_space_violation(*older, *view_, candidate.T_from_to);
  const auto decision = refused_at_start(violation);
  if (!decision) return std::nullopt;
  return without_match(candidate, violation, *decision);
}

VerifiedCandidate LoopCloser::Impl::matched(const Candidate& candidate) {
  if (!query_) query_ = submaps_.query(trajectory());
  const auto submap = submaps_.around(trajectory(), candidate.node);
  if (query_ && submap) return verified(candidate, *query_, *submap, config_, alignment_);
  return without_cloud(candidate);
}

/// Verifies the best candidates in turn. If the estimate allows only one location, the search ends
/// with the first accepted one; if locations may be confused, those at other locations follow.
std::vector<VerifiedCandidate> LoopCloser::Impl::verify_candidates() {
  const std::vector<Candidate> candidates = selected_candidates();
  if (candidates.empty()) return {};
  key_frames_since_search_ = 0;
  view_.reset();
  query_.reset();
  std::vector<VerifiedCandidate> verified;
  const auto is_shown = [&](const Candidate& candidate) {
    return std::any_of(verified.begin(), verified.end(), [&](const VerifiedCandidate& other) {
      return other.is_accepted() && shows_the_same(candidate, other, trajectory());
    });
  };
  for (const Candidate& candidate : candidates) {
    if (is_shown(candidate)) continue;
    const auto refused = refused_by_views(candidate);
    verified.push_back(refused ? *refused : matched(candidate));
    if (is_conclusive(verified.back())) break;
  }
  return verified;
}

/// Adds an accepted match to the result. Between segments that are not connected yet, it has to
/// wait until other matches agree with it; these are then accepted, too.
void LoopCloser::Impl::add_accepted(const VerifiedCandidate& verified, LoopClosingResult& result) {
  const Loop loop = to_loop(verified, trajectory(), config_);
  result.verdicts.push_back(to_verdict(verified, trajectory()));
  if (!is_unanchored(verified)) {
    result.loops.push_back(loop);
    return;
  }
  const std::vector<Loop> group = connector_.add(loop, trajectory());
  if (group.empty()) {
    result.verdicts.back().verdict = Verdict::kUndecided;
    result.verdicts.back().reason = waiting_reason(config_.unanchored_path_length);
  }
  for (const Loop& member : group) {
    result.loops.push_back(member);
    if (member.to != loop.to) result.verdicts.push_back(confirmed_verdict(member, loop));
  }
}

LoopClosingResult LoopCloser::Impl::process(const KeyFrame& key_frame,
                                            const PreparedKeyFrame& prepared) {
  add(key_frame, prepared);
  if (!is_due()) return {};
  std::vector<VerifiedCandidate> verified = verify_candidates();
  leave_rivals_undecided(verified, trajectory());
  refuse_all_but_best(verified, trajectory());
  LoopClosingResult result;
  for (const VerifiedCandidate& entry : verified) {
    if (entry.is_accepted()) {
      add_accepted(entry, result);
    } else {
      result.verdicts.push_back(to_verdict(entry, trajectory()));
    }
  }
  for (const Loop& loop : result.loops) add(loop);
  return result;
}

LoopCloser::LoopCloser(const LoopClosingConfig& config, CloudSource& clouds,
                       const std::filesystem::path& directory)
    : impl_(std::make_unique<Impl>(config, clouds, directory)) {}
LoopCloser::~LoopCloser() = default;

void LoopCloser::set_sensor_origin(const Eigen::Vector3d& p_base_lidar) {
  impl_->set_sensor_origin(p_base_lidar);
}
void LoopCloser::search_only_before(KeyFrameIndex end) { impl_->search_only_before(end); }
void LoopCloser::restore(const KeyFrame& key_frame) { impl_->add(key_frame, {}); }
void LoopCloser::restore(const std::vector<Loop>& loops, const std::vector<GnssPosition>& gnss,
                         const KeyFramePoses& poses) {
  for (const Loop& loop : loops) impl_->add(loop);
  for (const GnssPosition& position : gnss) impl_->add_gnss(position);
  impl_->update_poses(poses);
}
void LoopCloser::add_loop(const Loop& loop) { impl_->add(loop); }
void LoopCloser::update_poses(const KeyFramePoses& poses) { impl_->update_poses(poses); }
void LoopCloser::add_gnss(const GnssPosition& position) { impl_->add_gnss(position); }
LoopClosingResult LoopCloser::process(const KeyFrame& key_frame, const PreparedKeyFrame& prepared) {
  return impl_->process(key_frame, prepared);
}

}  // namespace lidar_mapping::loop_closing
