// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/session/loop_files.hpp"

#include "error_text.hpp"
#include "example_values.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::session {
namespace {

using test::TemporaryFolder;

Session session_with_loops(const std::filesystem::path& folder) {
  Session session = Session::create_in(folder);
  for (KeyFrameIndex index = 0; index < 8; ++index) {
    session.add_key_frame(example_key_frame(index));
  }
  for (const KeyFrameIndex to : {5U, 6U, 7U}) session.add_loop(example_loop(0, to));
  return session;
}

std::vector<LoopEdit> read_text(const TemporaryFolder& folder, const std::string& text) {
  const std::filesystem::path path = folder.path() / "edited.txt";
  std::ofstream(path) << text;
  return read_loop_list(path);
}

TEST(LoopFiles, TableHasTheNewestVerdictAndTheDecision) {
  const TemporaryFolder folder;
  Session session = session_with_loops(folder.path());
  session.set_loop_decision(0, 7, LoopDecision::kRefuse);
  LoopVerdict verdict;
  verdict.to = 7;
  verdict.verdict = Verdict::kAccepted;
  session.add_verdict(verdict);
  verdict.verdict = Verdict::kRefused;
  verdict.reason = "the graph says \"no\", 9 > 3";
  session.add_verdict(verdict);
  write_loops_csv(session, folder.path() / "loops.csv");

  std::ifstream file(folder.path() / "loops.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_NE(line.find(",qw,fitness,overlap,source,"), std::string::npos) << line;
  for (int i = 0; i < 3; ++i) std::getline(file, line);
  EXPECT_NE(line.find(",0.07,"), std::string::npos) << "the fitness: " << line;
  EXPECT_EQ(line.substr(0, 4), "0,7,");
  EXPECT_NE(line.find("appearance,refuse,refused,\"the graph says \"\"no\"\", 9 > 3\""),
            std::string::npos)
      << line;
}

TEST(LoopFiles, EachCandidateHasItsFiguresAndFinalVerdict) {
  const TemporaryFolder folder;
  Session session = session_with_loops(folder.path());
  LoopVerdict refused;
  refused.to = 3;
  refused.source = LoopSource::kAppearance;
  refused.verdict = Verdict::kRefused;
  refused.overlap = 0.25;
  refused.free_space_violation = 0.125;
  refused.horizontal_eigenvalue = 0.5;
  refused.innovation = 7.5;
  refused.distance = 30.0;
  refused.fitness = 1.5;
  refused.reason = "overlap 0.25, \"too little\"";
  session.add_verdict(refused);
  LoopVerdict accepted = refused;
  accepted.to = 5;
  accepted.verdict = Verdict::kAccepted;
  session.add_verdict(accepted);
  LoopVerdict by_graph;
  by_graph.to = 5;
  by_graph.verdict = Verdict::kRefused;
  by_graph.reason = "the graph leaves it out";
  session.add_verdict(by_graph);
  write_candidates_csv(session, folder.path() / "candidates.csv");

  std::ifstream file(folder.path() / "candidates.csv");
  std::string head, first, second, more;
  std::getline(file, head);
  std::getline(file, first);
  std::getline(file, second);
  EXPECT_EQ(std::count(head.begin(), head.end(), ','), 11);
  EXPECT_EQ(first,
            "0,3,0,appearance,refused,30,1.5,0.25,0.125,0.5,7.5,"
            "\"overlap 0.25, \"\"too little\"\"\"");
  EXPECT_EQ(second,
            "0,5,0,appearance,refused,30,1.5,0.25,0.125,0.5,7.5,\"the graph leaves it out\"");
  EXPECT_FALSE(std::getline(file, more)) << more;
}

TEST(LoopFiles, ReadsTheListThatItWrote) {
  const TemporaryFolder folder;
  Session session = session_with_loops(folder.path());
  session.set_loop_decision(0, 6, LoopDecision::kAccept);
  session.set_loop_decision(0, 7, LoopDecision::kRefuse);
  write_loop_list(session, folder.path() / "loops.txt");
  const std::vector<LoopEdit> edits = read_loop_list(folder.path() / "loops.txt");
  const std::vector<Loop> loops = session.loops();
  ASSERT_EQ(edits.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(edits[i].from, loops[i].from);
    EXPECT_EQ(edits[i].to, loops[i].to);
    EXPECT_EQ(edits[i].decision, loops[i].decision);
    EXPECT_FALSE(edits[i].add);
  }
  EXPECT_EQ(edits[2].decision, LoopDecision::kRefuse);
}

TEST(LoopFiles, AddedPairsMayHaveAGuessAndAnyOrder) {
  const TemporaryFolder folder;
  const auto edits = read_text(folder,
                               "# by hand\n\nadd 3 7  # same crossing\nadd 3 7 1 -2.5 0.1\n"
                               "add 7 3 1 0 0 0 0 90\n");
  ASSERT_EQ(edits.size(), 3U);
  EXPECT_FALSE(edits[0].guess);
  EXPECT_TRUE(edits[0].add);
  EXPECT_EQ(edits[0].decision, LoopDecision::kAccept);
  ASSERT_TRUE(edits[1].guess);
  EXPECT_EQ(edits[1].guess->translation, Eigen::Vector3d(1.0, -2.5, 0.1));
  ASSERT_TRUE(edits[2].guess);
  EXPECT_EQ(edits[2].from, 3U);
  const Pose quarter{exp_so3({0.0, 0.0, M_PI / 2.0}), Eigen::Vector3d::UnitX()};
  EXPECT_TRUE(test::near(edits[2].guess->inverse(), quarter, 1e-9));
}

TEST(LoopFiles, MalformedLinesAreRefusedByFileAndLine) {
  const TemporaryFolder folder;
  for (const char* line : {"keep 1 2", "accept 1", "accept 1 2 3", "add 1 2 3", "add 1 x",
                           "refuse -1 2", "add 1 2 nan 0 0", "add 1 2 1e300 0 0", "accept 1.5 2"}) {
    const std::string text = test::error_text<InputError>(
        [&] { read_text(folder, std::string("# head\n") + line + "\n"); });
    EXPECT_NE(text.find("edited.txt:2"), std::string::npos) << line << ": " << text;
  }
  EXPECT_THROW(read_loop_list(folder.path() / "none.txt"), FileError);
}

TEST(LoopFiles, DecisionsAreKeptWhenALoopIsReplaced) {
  const TemporaryFolder folder;
  Session session = session_with_loops(folder.path());
  session.set_loop_decision(0, 5, LoopDecision::kAccept);
  session.add_loop(example_loop(0, 5));
  const std::vector<Loop> loops = session.loops();
  EXPECT_EQ(loops.back().to, 5U);
  EXPECT_EQ(loops.back().decision, LoopDecision::kAccept);
}

// A session of the first version has no decisions. It can be read, and written after an upgrade.
TEST(LoopFiles, SessionsOfTheFirstVersionAreReadAndUpgraded) {
  const TemporaryFolder folder;
  session_with_loops(folder.path());
  execute(folder.path(),
          "DROP TABLE loop_decisions; ALTER TABLE key_frames DROP COLUMN doubtful; "
          "ALTER TABLE odometry DROP COLUMN drive; DROP TABLE scans; CREATE TABLE scans (stamp "
          "INTEGER PRIMARY "
          "KEY, state TEXT, fitness REAL, overlap REAL, seconds REAL, scans_dropped INTEGER); "
          "INSERT INTO scans VALUES (5, 'lost', 0.0, 0.0, 0.0, 0); PRAGMA user_version = 1");
  {
    const Session old = Session::open(folder.path(), Session::Access::kRead);
    ASSERT_EQ(old.loops().size(), 3U);
    EXPECT_EQ(old.loops()[0].decision, LoopDecision::kAuto);
    ASSERT_EQ(old.scans().size(), 1U);
    EXPECT_EQ(old.scans()[0].unobserved_stddev, 0.0);
    EXPECT_EQ(old.scans()[0].elevation_shift, 0.0);
    EXPECT_FALSE(old.scans()[0].probability.has_value());
  }
  Session session = Session::open(folder.path(), Session::Access::kWrite);
  session.set_loop_decision(0, 5, LoopDecision::kRefuse);
  EXPECT_EQ(session.loops()[0].decision, LoopDecision::kRefuse);
  session.add_scan({6, "degenerate", 0.0, 0.0, 0.0, 0, 0.5, 0.01, 0.9});
  EXPECT_FALSE(session.scans().front().probability.has_value());
  EXPECT_EQ(session.scans().back().probability, 0.9);
  EXPECT_EQ(session.scans().back().unobserved_stddev, 0.5);
  EXPECT_EQ(session.scans().back().elevation_shift, 0.01);
}

TEST(LoopFiles, ScansOfTheThirdVersionHaveNoElevationShift) {
  const TemporaryFolder folder;
  Session::create_in(folder.path()).add_scan({5, "tracking", 0.1, 0.9, 0.0, 0, 0.25, 0.01, {}});
  execute(folder.path(),
          "ALTER TABLE scans DROP COLUMN elevation_shift; "
          "ALTER TABLE key_frames DROP COLUMN doubtful; "
          "ALTER TABLE odometry DROP COLUMN drive; "
          "ALTER TABLE scans DROP COLUMN probability; PRAGMA user_version = 3");
  const Session old = Session::open(folder.path(), Session::Access::kRead);
  ASSERT_EQ(old.scans().size(), 1U);
  EXPECT_EQ(old.scans()[0].unobserved_stddev, 0.25);
  EXPECT_EQ(old.scans()[0].elevation_shift, 0.0);
}

TEST(LoopFiles, KeyFramesOfTheFifthVersionAreNotDoubtful) {
  const TemporaryFolder folder;
  Session::create_in(folder.path()).add_key_frame(example_key_frame(2));
  execute(folder.path(),
          "ALTER TABLE key_frames DROP COLUMN doubtful; "
          "ALTER TABLE odometry DROP COLUMN drive; PRAGMA user_version = 5");
  {
    const Session old = Session::open(folder.path(), Session::Access::kRead);
    ASSERT_EQ(old.key_frames().size(), 1U);
    EXPECT_FALSE(old.key_frames()[0].doubtful);
    EXPECT_EQ(old.key_frames()[0].stamp, example_key_frame(2).stamp);
    EXPECT_FALSE(old.key_frame(2)->doubtful);
  }
  Session session = Session::open(folder.path(), Session::Access::kWrite);
  session.add_key_frame(example_key_frame(4));
  EXPECT_FALSE(session.key_frames()[0].doubtful);
  EXPECT_TRUE(session.key_frames()[1].doubtful);
}

TEST(LoopFiles, ScansOfTheSixthVersionAreOfOneDrive) {
  const TemporaryFolder folder;
  Session::create_in(folder.path()).add_odometry({5, Pose(), 2});
  execute(folder.path(), "ALTER TABLE odometry DROP COLUMN drive; PRAGMA user_version = 6");
  {
    const Session old = Session::open(folder.path(), Session::Access::kRead);
    ASSERT_EQ(old.odometry().size(), 1U);
    EXPECT_EQ(old.odometry()[0].stamp, 5);
    EXPECT_EQ(old.odometry()[0].drive, 0U);
    EXPECT_FALSE(old.poses_in_enu());
  }
  Session session = Session::open(folder.path(), Session::Access::kWrite);
  session.add_odometry({6, Pose(), 2});
  ASSERT_EQ(session.odometry().size(), 2U);
  EXPECT_EQ(session.odometry()[0].drive, 0U);
  EXPECT_EQ(session.odometry()[1].drive, 2U);
}

}  // namespace
}  // namespace lidar_mapping::session
