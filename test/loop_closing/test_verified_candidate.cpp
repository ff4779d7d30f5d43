// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "decision/verified_candidate.hpp"
#include "drive.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

/// Key frames 10, 20, 30, ... at every second metre of a street.
Trajectory street() {
  Trajectory trajectory;
  for (std::size_t i = 1; i <= 5; ++i) {
    trajectory.append(key_frame(10 * i, planar(2.0 * static_cast<double>(i), 0.0, 0.0)));
  }
  return trajectory;
}

VerifiedCandidate verified_at(std::size_t node, double overlap, double violation,
                              Verdict verdict = Verdict::kAccepted) {
  VerifiedCandidate entry;
  entry.candidate.node = node;
  entry.match.figures.overlap = overlap;
  entry.match.figures.free_space_violation = violation;
  entry.decision = {verdict, "as it was"};
  return entry;
}

std::vector<Verdict> verdicts_of(const std::vector<VerifiedCandidate>& entries) {
  std::vector<Verdict> verdicts;
  for (const VerifiedCandidate& entry : entries) verdicts.push_back(entry.decision.verdict);
  return verdicts;
}

constexpr Verdict kYes = Verdict::kAccepted;
constexpr Verdict kNo = Verdict::kRefused;
constexpr Verdict kOpen = Verdict::kUndecided;

TEST(RefuseAllButBest, KeepsTheLargestMargin) {
  // Margins 0.7, 0.8 and 0.5: the largest overlap is not the best.
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.9, 0.1), verified_at(1, 0.82, 0.01),
                                            verified_at(2, 0.5, 0.0)};
  refuse_all_but_best(entries, street());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kNo, kYes, kNo}));
  EXPECT_EQ(entries[1].decision.reason, "as it was");
  for (const std::size_t other : {0, 2}) {
    EXPECT_NE(entries[other].decision.reason.find("key frame 20"), std::string::npos)
        << entries[other].decision.reason;
  }
}

TEST(RefuseAllButBest, PrefersAcceptedMatchesAndLeavesOthersAsTheyAre) {
  std::vector<VerifiedCandidate> entries = {
      verified_at(0, 1.0, 0.0, kOpen), verified_at(1, 0.6, 0.0), verified_at(2, 1.0, 0.0, kNo)};
  refuse_all_but_best(entries, street());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kOpen, kYes, kNo}));
  for (const VerifiedCandidate& entry : entries) EXPECT_EQ(entry.decision.reason, "as it was");
}

TEST(RefuseAllButBest, KeepsOneOfTwoEqualMatches) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.8, 0.0), verified_at(1, 0.8, 0.0)};
  refuse_all_but_best(entries, street());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kYes, kNo}));
}

TEST(RefuseAllButBest, AcceptsNoMatchesAtAll) {
  std::vector<VerifiedCandidate> none;
  refuse_all_but_best(none, street());
  std::vector<VerifiedCandidate> undecided = {verified_at(0, 0.8, 0.0, kOpen)};
  refuse_all_but_best(undecided, street());
  EXPECT_EQ(verdicts_of(undecided), std::vector<Verdict>{kOpen});
}

/// Of the street: a candidate from whose starting pose the newest key frame, which the estimate has
/// at x = 10 m, stands at `newest`.
Candidate starting_at(std::size_t node, const Pose& newest) {
  Candidate candidate;
  candidate.node = node;
  candidate.prior.anchored = true;
  candidate.T_from_to = street()[node].T_map_base.inverse() * newest;
  return candidate;
}
VerifiedCandidate matched_at(std::size_t node, const Pose& newest) {
  VerifiedCandidate entry = verified_at(node, 0.9, 0.0);
  entry.candidate = starting_at(node, newest);
  entry.match.alignment.T_target_source = entry.candidate.T_from_to;
  return entry;
}

TEST(ShowsTheSame, IfEstimateMatchAndStartingPoseAreOneLocation) {
  const Pose estimate = planar(10.0, 0.0, 0.0);
  const VerifiedCandidate accepted = matched_at(0, planar(10.2, 0.3, 0.02));
  EXPECT_TRUE(shows_the_same(starting_at(1, planar(10.6, 0.0, 0.0)), accepted, street()));
  EXPECT_FALSE(shows_the_same(starting_at(1, planar(10.2, 3.5, 0.0)), accepted, street()))
      << "the next lane";
  EXPECT_FALSE(shows_the_same(starting_at(1, planar(10.2, 0.3, kPi)), accepted, street()))
      << "the other direction";
  Pose storey = estimate;
  storey.translation.z() = 3.0;
  EXPECT_FALSE(shows_the_same(starting_at(1, storey), accepted, street())) << "the next storey";
  EXPECT_FALSE(shows_the_same(starting_at(1, planar(12.0, 0.0, 0.0)),
                              matched_at(0, planar(12.0, 0.0, 0.0)), street()))
      << "both contradict the estimate";
}

TEST(ShowsTheSame, OnlyWithinWhatConstraintsConnect) {
  const Pose estimate = planar(10.0, 0.0, 0.0);
  Candidate candidate = starting_at(1, estimate);
  VerifiedCandidate accepted = matched_at(0, estimate);
  ASSERT_TRUE(shows_the_same(candidate, accepted, street()));
  candidate.prior.height_jumps = 1.0;
  EXPECT_FALSE(shows_the_same(candidate, accepted, street()));
  candidate.prior.height_jumps = 0.0;
  accepted.candidate.prior.anchored = false;
  EXPECT_FALSE(shows_the_same(candidate, accepted, street()));
  accepted.candidate.prior.anchored = true;
  candidate.prior.anchored = false;
  EXPECT_FALSE(shows_the_same(candidate, accepted, street()));
}

/// Key frames 10 to 50 at 0, 40, 80, 120 and 160 m; the last one is of a segment of its own.
Trajectory two_segments() {
  Trajectory trajectory;
  for (std::size_t i = 0; i < 5; ++i) {
    KeyFrame frame = key_frame(10 * (i + 1), planar(40.0 * static_cast<double>(i), 0.0, 0.0));
    frame.segment = i == 4 ? 1 : 0;
    trajectory.append(frame);
  }
  return trajectory;
}

TEST(LeaveRivalsUndecided, WhereTwoPlacesLookAlike) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.95, 0.0), verified_at(2, 0.85, 0.0)};
  leave_rivals_undecided(entries, two_segments());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kOpen, kOpen}));
  EXPECT_NE(entries[0].decision.reason.find("key frame 30"), std::string::npos);
  EXPECT_NE(entries[1].decision.reason.find("key frame 10"), std::string::npos);
}

TEST(LeaveRivalsUndecided, UnlessOneFitsClearlyBetter) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.95, 0.0), verified_at(2, 0.75, 0.0)};
  leave_rivals_undecided(entries, two_segments());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kYes, kYes}));
}

TEST(LeaveRivalsUndecided, UnlessBothShowTheSamePlace) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.9, 0.0), verified_at(1, 0.9, 0.0)};
  entries[0].match.alignment.T_target_source = planar(39.0, 0.0, 0.0);
  entries[1].match.alignment.T_target_source = planar(-1.0, 5.0, 0.0);
  leave_rivals_undecided(entries, two_segments());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kYes, kYes}));
}

TEST(LeaveRivalsUndecided, UnlessTheEstimateIsAnchored) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.9, 0.0), verified_at(2, 0.9, 0.0)};
  entries[0].candidate.prior.anchored = true;
  entries[1].candidate.prior.anchored = true;
  leave_rivals_undecided(entries, two_segments());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kYes, kYes}));
}

TEST(LeaveRivalsUndecided, LeavesThoseThatWereNotAccepted) {
  std::vector<VerifiedCandidate> entries = {verified_at(0, 0.9, 0.0),
                                            verified_at(2, 0.9, 0.0, kNo)};
  leave_rivals_undecided(entries, two_segments());
  EXPECT_EQ(verdicts_of(entries), (std::vector<Verdict>{kYes, kNo}));
}

TEST(IsConclusive, NeedsAnAcceptedMatchThatAgreesWithACertainEstimate) {
  VerifiedCandidate entry = verified_at(1, 0.9, 0.0);
  entry.candidate.prior.anchored = true;
  entry.candidate.prior.sigma_horizontal = 0.5;
  entry.candidate.prior.sigma_vertical = 0.1;
  entry.candidate.prior.sigma_rotation = 0.02;
  EXPECT_TRUE(is_conclusive(entry));
  entry.decision.verdict = kOpen;
  EXPECT_FALSE(is_conclusive(entry));
  entry.decision.verdict = kYes;
  entry.match.alignment.T_target_source = planar(5.0, 0.0, 0.0);
  EXPECT_FALSE(is_conclusive(entry)) << "ten standard deviations from the estimate";
}

VerifiedCandidate complete_entry() {
  VerifiedCandidate entry = verified_at(1, 0.9, 0.05);
  entry.candidate.source = LoopSource::kGnss;
  entry.candidate.prior.anchored = true;
  entry.candidate.prior.T_from_to = planar(3.0, 4.0, 0.0);
  entry.candidate.prior.sigma_horizontal = 1.0;
  entry.candidate.prior.sigma_vertical = 1.0;
  entry.candidate.prior.sigma_rotation = 0.1;
  entry.match.alignment.T_target_source = planar(3.5, 4.0, 0.1);
  entry.match.alignment.covariance = diagonal_covariance(0.03, 0.004);
  entry.match.figures.fitness = 0.07;
  entry.match.figures.sight = 60.0;
  entry.match.figures.horizontal_eigenvalue = 0.21;
  return entry;
}

TEST(ToLoop, JoinsTheCandidateAndTheNewestKeyFrameAsMatched) {
  LoopClosingConfig config;
  config.min_stddev_x = 0.04;
  config.min_stddev_q = 0.003;
  const Trajectory trajectory = street();
  const Loop loop = to_loop(complete_entry(), trajectory, config);
  EXPECT_EQ(loop.from, 20U);
  EXPECT_EQ(loop.to, 50U);
  EXPECT_EQ(loop.stamp, trajectory[4].stamp);
  EXPECT_EQ(loop.source, LoopSource::kGnss);
  EXPECT_EQ(loop.fitness, 0.07);
  EXPECT_EQ(loop.overlap, 0.9);
  EXPECT_TRUE(near(loop.T_from_to, planar(3.5, 4.0, 0.1), 1e-12)) << "not the estimate before";
  // 3-4-5: 0.03 m by the match and 0.04 m of the submap are 0.05 m; 4 and 3 mrad are 5 mrad.
  EXPECT_TRUE(near(loop.covariance, diagonal_covariance(0.05, 0.005), 1e-12));
}

// Both see 20 m, and 5.3 m are no longer close: the lower bound grows five times.
TEST(ToLoop, IsLessCertainIfTheKeyFramesAreNotClose) {
  LoopClosingConfig config;
  config.min_stddev_x = 0.008;
  config.min_stddev_q = 0.0006;
  VerifiedCandidate entry = complete_entry();
  entry.match.figures.sight = 20.0;
  const Loop loop = to_loop(entry, street(), config);
  // 3-4-5 again: 0.03 m and 0.04 m; 4 and 3 mrad.
  EXPECT_TRUE(near(loop.covariance, diagonal_covariance(0.05, 0.005), 1e-12));
}

TEST(ToVerdict, HasTheFiguresOfTheMatchAndTheDistanceBeforeIt) {
  const Trajectory trajectory = street();
  VerifiedCandidate entry = complete_entry();
  entry.decision = {kNo, "too little overlap"};
  const LoopVerdict verdict = to_verdict(entry, trajectory);
  EXPECT_EQ(verdict.from, 20U);
  EXPECT_EQ(verdict.to, 50U);
  EXPECT_EQ(verdict.stamp, trajectory[4].stamp);
  EXPECT_EQ(verdict.source, LoopSource::kGnss);
  EXPECT_EQ(verdict.verdict, kNo);
  EXPECT_EQ(verdict.reason, "too little overlap");
  EXPECT_DOUBLE_EQ(verdict.distance, 5.0) << "3-4-5, by the estimate";
  EXPECT_EQ(verdict.fitness, 0.07);
  EXPECT_EQ(verdict.overlap, 0.9);
  EXPECT_EQ(verdict.free_space_violation, 0.05);
  EXPECT_EQ(verdict.horizontal_eigenvalue, 0.21);
  // 0.5 m of 1 m and 0.1 rad of 0.1 rad, if the least uncertainties of the prior are left out.
  EXPECT_GT(verdict.innovation, 0.5);
  EXPECT_LT(verdict.innovation, 0.25 + 1.0);
}

TEST(ConfirmedVerdict, NamesTheMatchThatConfirms) {
  Loop early;
  early.from = 4;
  early.to = 90;
  Loop late;
  late.from = 15;
  late.to = 120;
  const LoopVerdict verdict = confirmed_verdict(early, late);
  EXPECT_EQ(verdict.from, 4U);
  EXPECT_EQ(verdict.to, 90U);
  EXPECT_EQ(verdict.verdict, kYes);
  EXPECT_NE(verdict.reason.find("key frames 15 and 120"), std::string::npos) << verdict.reason;
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
