// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/loop_edits.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"
#include "town_session.hpp"

namespace lidar_mapping::pipeline::test {
namespace {

using lidar_mapping::test::near;
using lidar_mapping::test::TemporaryFolder;
using session::Session;

/// A drive once round a block, whose odometry ends metres beside the start.
class LoopEdits : public ::testing::Test {
 protected:
  LoopEdits()
      : world_(make_town(90.0, 60.0, 1)),
        truth_(along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}, {10, 0}})),
        session_(record_drive(folder_.path() / "session", world_, truth_,
                              drifting(truth_, 1.01, 4e-4))) {}

  KeyFrameIndex last() const { return static_cast<KeyFrameIndex>(truth_.size() - 1); }
  Pose true_motion(const Loop& loop) const { return truth_[loop.from].inverse() * truth_[loop.to]; }

  std::vector<Loop> edited(const std::string& list) {
    const std::filesystem::path path = folder_.path() / "edited.txt";
    std::ofstream(path) << list;
    return edited_loops(session_, session::read_loop_list(path), {});
  }

  /// Error of the pose of the end of the loop after an optimisation with the whole session, m.
  double error_after(const Loop& loop) {
    RecordedBackEnd back_end(std::move(session_), {});
    const auto poses = back_end.apply(*back_end::solve(*back_end.problem(true)), 0.0).poses.poses;
    verdicts_ = back_end.verdicts();
    const Pose motion = poses[loop.from].T_map_base.inverse() * poses[loop.to].T_map_base;
    return difference(loop.T_from_to, motion).head<3>().norm();
  }

  Loop false_loop() const {
    Loop loop;
    loop.from = 3;
    loop.to = last() - 1;
    loop.stamp = kStart;
    loop.T_from_to.translation = {-6.0, 5.0, 0.0};
    loop.covariance = diagonal_covariance(0.05, 0.005);
    return loop;
  }

  TemporaryFolder folder_;
  const ToyWorld world_;
  const std::vector<Pose> truth_;
  Session session_;
  std::vector<LoopVerdict> verdicts_;
};

TEST_F(LoopEdits, AddedPairIsMatchedAndStored) {
  const std::string text = "add 1 " + std::to_string(last() - 4) + "\n";
  const std::vector<Loop> loops = edited(text);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].source, LoopSource::kManual);
  EXPECT_TRUE(near(loops[0].T_from_to, true_motion(loops[0]), 0.1));
  EXPECT_TRUE(session_.loops().empty()) << "matching writes nothing";
  store_decisions(session_, loops);
  EXPECT_EQ(session_.loops().at(0).decision, LoopDecision::kAccept);
  EXPECT_LT(error_after(loops[0]), 0.05);
}

TEST_F(LoopEdits, MatchingStartsAtGuess) {
  const std::string pair = "add 1 " + std::to_string(last() - 4);
  EXPECT_EQ(edited(pair + " 0.5 -0.5 0 0 0 3\n").size(), 1U);
  EXPECT_THROW(edited(pair + " 25 20 0 0 0 90\n"), InputError);
}

TEST_F(LoopEdits, PairWithoutMatchIsReportedWithLine) {
  const std::string text =
      lidar_mapping::test::error_text<InputError>([&] { edited("# two streets\nadd 5 50\n"); });
  EXPECT_NE(text.find("edited.txt:2: key frames 5 and 50 do not match"), std::string::npos) << text;
  EXPECT_THROW(edited("add 5 9\n"), InputError) << "they share clouds";
  EXPECT_THROW(edited("add 5 5000\n"), InputError);
  EXPECT_THROW(edited("refuse 5 50\n"), InputError) << "there is no such loop";
  EXPECT_TRUE(session_.loops().empty());
}

TEST_F(LoopEdits, RefusedLoopIsLeftOut) {
  session_.add_loop(false_loop());
  const std::vector<Loop> loops = edited("refuse 3 " + std::to_string(last() - 1) + "\n");
  store_decisions(session_, loops);
  EXPECT_GT(error_after(false_loop()), 3.0);
  ASSERT_EQ(verdicts_.size(), 1U);
  EXPECT_EQ(verdicts_[0].verdict, Verdict::kRefused);
  EXPECT_EQ(verdicts_[0].reason, "a person refused it");
}

TEST_F(LoopEdits, TheLastLineOfAPairHolds) {
  session_.add_loop(false_loop());
  const std::string pair = " 3 " + std::to_string(last() - 1) + "\n";
  EXPECT_TRUE(edited("refuse" + pair + "auto" + pair).empty()) << "as the session has it";
  const std::vector<Loop> loops = edited("auto" + pair + "accept" + pair + "refuse" + pair);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].decision, LoopDecision::kRefuse);
}

/// Three true loops outvote the false one unless a person accepts it.
TEST_F(LoopEdits, AcceptedLoopPrevailsOverGraph) {
  session_.add_loop(false_loop());
  for (const KeyFrameIndex to : {last() - 5, last() - 3, last()}) {
    Loop loop;
    loop.from = 1;
    loop.to = to;
    loop.stamp = kStart;
    loop.T_from_to = true_motion(loop);
    loop.covariance = diagonal_covariance(0.02, 0.002);
    session_.add_loop(loop);
  }
  const std::string name = folder_.path() / "session";
  EXPECT_GT(error_after(false_loop()), 3.0) << "left out without a decision";
  session_ = Session::open(name, Session::Access::kRead);
  const auto loops = edited("accept " + std::to_string(last() - 1) + " 3\n");
  ASSERT_EQ(loops.size(), 1U);
  back_end::BackEnd back_end({});
  replay(session_, replace_loops(session_.loops(), loops), back_end);
  const auto solution = back_end::solve(*back_end.problem(true));
  back_end.apply(*solution);
  EXPECT_TRUE(back_end.loops().at(0).second);
  EXPECT_EQ(session_.loops().at(0).decision, LoopDecision::kAuto) << "solved aside";
}

}  // namespace
}  // namespace lidar_mapping::pipeline::test
