// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>

#include "lidar_mapping/pose_graph/least_eigenvalue.hpp"

#include "back_end_fixture.hpp"
#include "drive/drive_window.hpp"
#include "near.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::feed;
using test::make_loop;
using test::optimize;
using test::SyntheticDrive;

/// 4400 key frames around a street block, connected by many loops and solved.
struct LongDrive {
  SyntheticDrive drive;
  BackEnd back_end{BackEndConfig{}};
  std::mt19937 engine{11};

  LongDrive() {
    test::DriveSettings settings;
    settings.laps = 11;
    settings.turn_bias_deg = 0.001;
    drive = test::make_drive(settings);
    feed(back_end, drive);
    test::add_lap_loops(back_end, drive, 400, 10, engine);
    EXPECT_TRUE(optimize(back_end).success);
  }
};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST(Window, ANewLoopIsSolvedInAWindow) {
  LongDrive run;
  const auto before = run.back_end.poses().poses;
  run.back_end.add_loop(make_loop(run.drive, 2005, 2405, run.engine));
  const auto problem = run.back_end.problem();
  ASSERT_TRUE(problem->window);
  EXPECT_LT(problem->drive.nodes.size(), 1500U);
  const double begin = cpu_seconds();
  const auto solution = solve(*problem);
  const double in_window = cpu_seconds() - begin;
  EXPECT_TRUE(report_of(*solution).success);
  EXPECT_EQ(report_of(*solution).key_frames, 4400U) << "the report is about the whole drive";
  EXPECT_EQ(report_of(*solution).loops_used, run.back_end.loops().size());
  run.back_end.apply(*solution);
  EXPECT_TRUE(run.back_end.loops().back().second);
  const auto after = run.back_end.poses().poses;
  EXPECT_EQ(after.size(), before.size());
  // The solution of the whole graph agrees within a centimetre and takes much longer.
  const double middle = cpu_seconds();
  optimize(run.back_end, true);
  EXPECT_LT(in_window, 0.5 * (cpu_seconds() - middle));
  const auto whole = run.back_end.poses().poses;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_TRUE(test::near(after[i].T_map_base.translation, whole[i].T_map_base.translation, 0.01));
  }
}

TEST(Window, AContradictingLoopIsSolvedInTheWholeGraph) {
  LongDrive run;
  Loop loop = make_loop(run.drive, 2005, 2405, run.engine);
  // Small enough for a window, but false.
  Vector6d offset = Vector6d::Zero();
  offset << 0.17, 0.17, 0.0, 0.0, 0.0, 0.015;
  loop.T_from_to = perturbed(loop.T_from_to, offset);
  run.back_end.add_loop(loop);
  const auto problem = run.back_end.problem();
  ASSERT_TRUE(problem->window);
  const auto before = run.back_end.poses().poses;
  const auto solution = solve(*problem);
  ASSERT_TRUE(solution->full_solve_needed);
  run.back_end.apply(*solution);
  EXPECT_EQ(before[2405].T_map_base.translation,
            run.back_end.poses().poses[2405].T_map_base.translation);
  EXPECT_FALSE(run.back_end.problem()->window);
  optimize(run.back_end);
  EXPECT_FALSE(run.back_end.loops().back().second);
}

TEST(Window, ALargeCorrectionIsSolvedInTheWholeGraph) {
  LongDrive run;
  Loop loop = make_loop(run.drive, 2005, 2405, run.engine);
  loop.T_from_to.translation.x() += 10.0;
  run.back_end.add_loop(loop);
  EXPECT_FALSE(run.back_end.problem()->window) << "ten metres are not absorbed in a window";
}

/// Two segments of 500 key frames along x, 50 m apart. GNSS has aligned the first one, and a loop
/// between their beginnings the second one, which has a new position in its middle.
DriveGraph segments_aligned_by_a_loop() {
  DriveGraph drive;
  for (int i = 0; i < 1000; ++i) {
    DriveNode node;
    node.index = static_cast<KeyFrameIndex>(i);
    node.segment = i / 500;
    node.connected = i % 500 > 0;
    node.stamp = from_seconds(i);
    node.T_odom_base.translation = {1.0 * (i % 500), 0.0, 0.0};
    node.T_map_base.translation = {1.0 * (i % 500), 50.0 * node.segment, 0.0};
    drive.nodes.push_back(node);
  }
  drive.segment_starts = {0, 500};
  drive.in_enu = {true, false};
  drive.gnss_delays = {GnssDelay{}, GnssDelay{}};
  DriveLoop loop;
  loop.from = 0;
  loop.to = 500;
  loop.used = true;
  loop.evaluated = true;
  drive.loops.push_back(loop);
  DriveGnss gnss;
  gnss.node = 750;
  gnss.position.p_enu_antenna = drive.nodes[750].T_map_base.translation;
  drive.gnss.push_back(gnss);
  return drive;
}

TEST(Window, HasThePositionsOfASegmentThatLoopsAloneHaveAligned) {
  const DriveGraph drive = segments_aligned_by_a_loop();
  const auto window = window_around_new_data(drive, BackEndConfig{});
  ASSERT_TRUE(window) << "the whole graph would be solved for every position";
  EXPECT_TRUE(window->loops.empty());
  const DriveGraph part = extract_window(drive, *window);
  ASSERT_EQ(part.gnss.size(), 1U);
  EXPECT_TRUE(segments_in_enu(part).at(1)) << "else the window leaves its positions out";
}

DriveLoop new_loop(int from, int to, const DriveGraph& drive) {
  DriveLoop loop;
  loop.from = from;
  loop.to = to;
  loop.loop.T_from_to = drive.nodes[from].T_map_base.inverse() * drive.nodes[to].T_map_base;
  return loop;
}

/// As the loops of a session that is resumed have, whose new part is a segment of its own.
TEST(Window, ContainsALoopBetweenSegmentsThatALoopHasConnected) {
  DriveGraph drive = segments_aligned_by_a_loop();
  drive.gnss.clear();
  drive.loops.push_back(new_loop(250, 750, drive));
  const auto window = window_around_new_data(drive, BackEndConfig{});
  ASSERT_TRUE(window) << "the whole graph would be solved for every loop of a resumed session";
  EXPECT_EQ(window->loops, std::vector<int>{1});
  EXPECT_EQ(window->nodes.front(), 199);
  EXPECT_EQ(window->nodes.back(), 801);
}

TEST(Window, DoesNotContainTheLoopThatConnectsTwoSegments) {
  DriveGraph drive = segments_aligned_by_a_loop();
  drive.gnss.clear();
  drive.loops = {new_loop(250, 750, drive)};
  EXPECT_FALSE(window_around_new_data(drive, BackEndConfig{})) << "a whole segment may move";
}

TEST(LeastEigenvalue, IsZeroForAFreeMotionAndGrowsWithConstraints) {
  pose_graph::FactorGraph graph;
  for (int i = 0; i < 4; ++i) graph.add_node({exp_so3({0.0, 0.0, 0.3 * i}), {1.0 * i, 0.0, 0.0}});
  for (int i = 1; i < 4; ++i) {
    const Pose motion = graph.pose(i - 1).inverse() * graph.pose(i);
    graph.add({pose_graph::relative_pose_residual(motion, 100.0 * Matrix6d::Identity()), i - 1, i});
  }
  EXPECT_LT(pose_graph::least_eigenvalue(graph, {true, true, true}), 1e-9);
  graph.add({pose_graph::prior_residual(graph.pose(0), 4.0 * Matrix6d::Identity()), 0});
  const double eigenvalue = pose_graph::least_eigenvalue(graph, {true, true, true, true});
  EXPECT_GT(eigenvalue, 0.01);
  EXPECT_LT(eigenvalue, 4.0);
  // A second connection at the other end increases the eigenvalue.
  graph.add({pose_graph::prior_residual(graph.pose(3), 400.0 * Matrix6d::Identity()), 3});
  EXPECT_GT(pose_graph::least_eigenvalue(graph, {true, true, true, true, true}), 2.0 * eigenvalue);
}

TEST(LeastEigenvalue, IsReportedByAThoroughOptimisation) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  test::feed(back_end, drive);
  const auto report = report_of(*solve(*back_end.problem(true)));
  EXPECT_GT(report.least_eigenvalue, 0.0);
  EXPECT_NE(report.message.find("smallest eigenvalue"), std::string::npos) << report.message;
}

}  // namespace
}  // namespace lidar_mapping::back_end
