// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/loop.hpp"

namespace lidar_mapping {
namespace {

TEST(LoopNames, ComeBackAsTheSameValue) {
  for (const LoopSource source :
       {LoopSource::kPosition, LoopSource::kGnss, LoopSource::kAppearance, LoopSource::kManual}) {
    EXPECT_EQ(loop_source_from(to_string(source)), source);
  }
  for (const LoopDecision decision :
       {LoopDecision::kAuto, LoopDecision::kAccept, LoopDecision::kRefuse}) {
    EXPECT_EQ(loop_decision_from(to_string(decision)), decision);
  }
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRefused, Verdict::kUndecided}) {
    EXPECT_EQ(verdict_from(to_string(verdict)), verdict);
  }
}

// Sessions, messages and files hold them.
TEST(LoopNames, AreThoseOfTheFiles) {
  EXPECT_STREQ(to_string(LoopSource::kAppearance), "appearance");
  EXPECT_STREQ(to_string(LoopDecision::kRefuse), "refuse");
  EXPECT_STREQ(to_string(Verdict::kUndecided), "undecided");
}

TEST(LoopNames, OfNothingAreRefused) {
  for (const std::string word : {"", "Position", "position ", "refused"}) {
    EXPECT_THROW(loop_source_from(word), InputError) << word;
    EXPECT_THROW(loop_decision_from(word), InputError) << word;
  }
  EXPECT_THROW(verdict_from("refuse"), InputError) << "a decision, no verdict";
}

TEST(VerdictOn, HasWhatTheLoopKnows) {
  Loop loop;
  loop.from = 3;
  loop.to = 70;
  loop.stamp = 12;
  loop.source = LoopSource::kManual;
  loop.fitness = 0.2;
  loop.overlap = 0.7;
  const LoopVerdict verdict = verdict_on(loop, Verdict::kRefused, "the user says so");
  EXPECT_EQ(verdict.from, 3U);
  EXPECT_EQ(verdict.to, 70U);
  EXPECT_EQ(verdict.stamp, 12);
  EXPECT_EQ(verdict.source, LoopSource::kManual);
  EXPECT_EQ(verdict.verdict, Verdict::kRefused);
  EXPECT_EQ(verdict.reason, "the user says so");
  EXPECT_EQ(verdict.fitness, 0.2);
  EXPECT_EQ(verdict.overlap, 0.7);
}

TEST(NewestVerdicts, AreTheLastOnesOfEachPair) {
  const auto verdict = [](KeyFrameIndex from, KeyFrameIndex to, const std::string& reason) {
    LoopVerdict result;
    result.from = from;
    result.to = to;
    result.reason = reason;
    return result;
  };
  const auto newest = newest_verdicts({verdict(1, 9, "early"), verdict(2, 9, "other"),
                                       verdict(9, 1, "reverse"), verdict(1, 9, "late")});
  ASSERT_EQ(newest.size(), 3U);
  EXPECT_EQ(newest.at({1, 9}).reason, "late");
  EXPECT_EQ(newest.at({2, 9}).reason, "other");
  EXPECT_EQ(newest.at({9, 1}).reason, "reverse");
}

}  // namespace
}  // namespace lidar_mapping
