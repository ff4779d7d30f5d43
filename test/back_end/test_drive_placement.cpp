// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "drive/drive_placement.hpp"
#include "near.hpp"
#include "synthetic_drive.hpp"

namespace lidar_mapping::back_end {
namespace {

constexpr int kSegmentNodes = 40;  // one round of the block

const Pose kElsewhere{exp_so3({0.0, 0.0, 0.7}), {80.0, -30.0, 4.0}};
const Pose kFarAway{exp_so3({0.0, 0.0, -1.9}), {-500.0, 900.0, -7.0}};
const Eigen::Vector3d kArm(0.5, 0.2, 1.5);

test::SyntheticDrive rounds(int count) {
  test::DriveSettings settings;
  settings.laps = count;
  settings.spacing = 4.0 * settings.side / kSegmentNodes;
  return test::make_drive(settings);
}

/// Segments that begin in frames of their own: `T_map_enu[s]` tells where segment s lies in the
/// map.
class Segments {
 public:
  explicit Segments(std::vector<Pose> T_map_enu)
      : truth_(rounds(static_cast<int>(T_map_enu.size())).truth), T_map_enu_(std::move(T_map_enu)) {
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      DriveNode node;
      node.segment = static_cast<int>(i) / kSegmentNodes;
      node.connected = i % kSegmentNodes > 0;
      node.stamp = from_seconds(static_cast<double>(i));
      node.T_map_base = T_map_enu_[node.segment] * truth_[i];
      node.T_odom_base = node.T_map_base;
      drive.nodes.push_back(node);
    }
    for (std::size_t s = 0; s < T_map_enu_.size(); ++s) {
      drive.in_enu.push_back(false);
      drive.gnss_delays.emplace_back();
      drive.segment_starts.push_back(static_cast<int>(s) * kSegmentNodes);
    }
    drive.T_map_first = drive.nodes.front().T_map_base;
  }

  /// A new loop between two nodes; by `error` beside the truth.
  DriveLoop& add_loop(int from, int to, const Pose& error = {}) {
    DriveLoop loop;
    loop.from = from;
    loop.to = to;
    loop.loop.T_from_to = truth(from).inverse() * truth(to) * error;
    drive.loops.push_back(loop);
    return drive.loops.back();
  }
  void add_loop_in_use(int from, int to) {
    DriveLoop& loop = add_loop(from, to);
    loop.evaluated = loop.used = true;
  }
  void add_gnss(int node, double stddev = 0.1) {
    DriveGnss gnss;
    gnss.node = node;
    gnss.position.p_base_antenna = kArm;
    gnss.position.p_enu_antenna = truth(node) * kArm;
    gnss.position.covariance = stddev * stddev * Eigen::Matrix3d::Identity();
    drive.gnss.push_back(gnss);
  }
  void add_gnss_to_segment(int segment) {
    for (int i = 0; i < kSegmentNodes; ++i) add_gnss(segment * kSegmentNodes + i);
  }

  const Pose& truth(int node) const { return truth_[node]; }
  /// Whether a segment lies where this frame has it.
  testing::AssertionResult is_at(int segment, const Pose& T_map_enu, double tolerance = 1e-9) {
    for (int i = segment * kSegmentNodes; i < (segment + 1) * kSegmentNodes; ++i) {
      const Pose& found = drive.nodes[i].T_map_base;
      const auto result = test::near(found, T_map_enu * truth(i), tolerance);
      if (!result) return testing::AssertionFailure() << "node " << i << ": " << result.message();
    }
    return testing::AssertionSuccess();
  }

  DriveGraph drive;

 private:
  std::vector<Pose> truth_;
  std::vector<Pose> T_map_enu_;
};

TEST(ConnectSegments, MovesTheNewerSegmentByANewLoop) {
  for (const bool newer_end_is_to : {true, false}) {
    Segments segments({kFarAway, kElsewhere});
    const int old_node = 3;
    const int new_node = kSegmentNodes + 5;
    segments.add_loop(newer_end_is_to ? old_node : new_node, newer_end_is_to ? new_node : old_node);
    connect_segments(segments.drive);
    EXPECT_TRUE(segments.is_at(0, kFarAway)) << "the older one stays";
    EXPECT_TRUE(segments.is_at(1, kFarAway)) << newer_end_is_to;
    EXPECT_TRUE(test::near(segments.drive.T_map_first, kFarAway * segments.truth(0), 1e-9));
  }
}

TEST(ConnectSegments, FollowsTheLoopsThatMostOthersAgreeWith) {
  Segments segments({Pose(), kElsewhere});
  const Pose false_place{Eigen::Quaterniond::Identity(), {30.0, 0.0, 0.0}};
  segments.add_loop(7, kSegmentNodes + 1, false_place);
  segments.add_loop(8, kSegmentNodes + 2, false_place);
  const Pose small_error{exp_so3({0.0, 0.0, 0.002}), {0.05, -0.02, 0.01}};
  for (const int i : {5, 15, 25}) segments.add_loop(i, kSegmentNodes + i, small_error);
  segments.add_loop(9, kSegmentNodes + 3, Pose{Eigen::Quaterniond::Identity(), {0.0, 40.0, 0.0}});
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(1, Pose(), 0.5));
}

TEST(ConnectSegments, LoopsThatWereDecidedMoveNothing) {
  Segments segments({Pose(), kElsewhere});
  segments.add_loop(3, kSegmentNodes + 3).evaluated = true;
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(1, kElsewhere)) << "the loop was refused";

  segments.add_loop_in_use(4, kSegmentNodes + 4);
  segments.add_loop(5, kSegmentNodes + 5);
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(1, kElsewhere)) << "the segments are connected already";
}

TEST(ConnectSegments, LoopsThatWereRefusedHaveNoVote) {
  Segments segments({Pose(), kElsewhere});
  const Pose false_place{Eigen::Quaterniond::Identity(), {30.0, 0.0, 0.0}};
  for (const int i : {6, 7, 8}) {
    segments.add_loop(i, kSegmentNodes + i, false_place).evaluated = true;
  }
  segments.add_loop(20, kSegmentNodes + 20);
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(1, Pose()));
}

TEST(ConnectSegments, MovesConnectedSegmentsTogether) {
  Segments segments({Pose(), kElsewhere, kElsewhere});
  segments.add_loop_in_use(kSegmentNodes + 4, 2 * kSegmentNodes + 4);
  segments.add_loop(9, 2 * kSegmentNodes + 9);
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(0, Pose()));
  EXPECT_TRUE(segments.is_at(1, Pose())) << "it is tied to the one with the loop";
  EXPECT_TRUE(segments.is_at(2, Pose()));
}

// Drives that are merged at once: the way from the oldest one leads over another.
TEST(ConnectSegments, PlacesAChainFromItsOldestSegmentOn) {
  for (const bool is_2_in_the_middle : {false, true}) {
    for (const bool is_far_loop_first : {false, true}) {
      Segments segments({Pose(), kElsewhere, kFarAway});
      const int middle = (is_2_in_the_middle ? 2 : 1) * kSegmentNodes;
      const int end = (is_2_in_the_middle ? 1 : 2) * kSegmentNodes;
      if (is_far_loop_first) segments.add_loop(middle + 9, end + 9);
      segments.add_loop(4, middle + 4);
      if (!is_far_loop_first) segments.add_loop(middle + 9, end + 9);
      connect_segments(segments.drive);
      EXPECT_TRUE(segments.is_at(1, Pose())) << is_2_in_the_middle << is_far_loop_first;
      EXPECT_TRUE(segments.is_at(2, Pose())) << is_2_in_the_middle << is_far_loop_first;
    }
  }
}

BackEndConfig with_gnss() {
  BackEndConfig config;
  config.use_gnss = true;
  return config;
}

TEST(Georeferencing, AlignsALongTrackToEastNorthUp) {
  Segments segments({kElsewhere});
  segments.add_gnss_to_segment(0);
  const Georeference found = georeference(segments.drive, with_gnss(), false);
  EXPECT_TRUE(found.newly_aligned);
  EXPECT_EQ(found.inliers, static_cast<std::size_t>(kSegmentNodes));
  EXPECT_LT(found.rms_horizontal, 1e-6);
  EXPECT_TRUE(segments.drive.in_enu[0]);
  EXPECT_TRUE(segments.is_at(0, Pose(), 1e-6));
  EXPECT_TRUE(test::near(segments.drive.T_map_first, segments.truth(0), 1e-6))
      << "the prior goes with its node";
}

TEST(Georeferencing, PositionsWithoutAltitudeDoNotChangeTheHeight) {
  Segments segments({kElsewhere});
  segments.add_gnss_to_segment(0);
  for (std::size_t i = 0; i < segments.drive.gnss.size(); ++i) {
    if (i % 3 == 0) continue;
    GnssPosition& position = segments.drive.gnss[i].position;
    position.p_enu_antenna.z() += 500.0;
    position.covariance(2, 2) = 0.0;  // what receivers write that have no altitude
  }
  georeference(segments.drive, with_gnss(), false);
  EXPECT_TRUE(segments.is_at(0, Pose(), 1e-6));
}

TEST(Georeferencing, WaitsForALongTrackAndForItsSwitch) {
  Segments segments({kElsewhere});
  for (int i = 0; i < 2; ++i) segments.add_gnss(i);
  EXPECT_FALSE(georeference(segments.drive, with_gnss(), false).newly_aligned);
  EXPECT_TRUE(segments.is_at(0, kElsewhere));

  for (int i = 2; i < kSegmentNodes; ++i) segments.add_gnss(i);
  BackEndConfig off = with_gnss();
  off.use_gnss = false;
  EXPECT_FALSE(georeference(segments.drive, off, false).newly_aligned);
  EXPECT_FALSE(segments.drive.in_enu[0]);
  EXPECT_TRUE(segments.is_at(0, kElsewhere));
}

TEST(Georeferencing, AlignsAgainOnlyIfAsked) {
  Segments segments({kElsewhere});
  segments.add_gnss_to_segment(0);
  segments.drive.in_enu[0] = true;
  EXPECT_EQ(georeference(segments.drive, with_gnss(), false).inliers, 0U);
  EXPECT_TRUE(segments.is_at(0, kElsewhere));
  const Georeference again = georeference(segments.drive, with_gnss(), true);
  EXPECT_EQ(again.inliers, static_cast<std::size_t>(kSegmentNodes));
  EXPECT_FALSE(again.newly_aligned);
  EXPECT_TRUE(segments.is_at(0, Pose(), 1e-6));
}

TEST(Georeferencing, MovesWhatLoopsConnectAndNothingElse) {
  Segments segments({kElsewhere, kElsewhere, kFarAway});
  segments.add_gnss_to_segment(0);
  segments.add_loop_in_use(4, kSegmentNodes + 4);
  georeference(segments.drive, with_gnss(), false);
  EXPECT_TRUE(segments.is_at(0, Pose(), 1e-6));
  EXPECT_TRUE(segments.is_at(1, Pose(), 1e-6)) << "a loop ties it to the one with positions";
  EXPECT_TRUE(segments.is_at(2, kFarAway));
  EXPECT_EQ(segments.drive.in_enu, (std::vector<bool>{true, true, false}));
}

// The older segment has no positions: a map from elsewhere, or a drive without a receiver.
TEST(Georeferencing, AlignsWhatJoinsASegmentThatIsNotInEastNorthUp) {
  Segments segments({kElsewhere, Pose()});
  segments.add_gnss_to_segment(1);
  segments.drive.in_enu[1] = true;
  segments.add_loop(4, kSegmentNodes + 4);
  connect_segments(segments.drive);
  EXPECT_TRUE(segments.is_at(1, kElsewhere)) << "it is placed beside the older one";
  EXPECT_FALSE(segments.drive.in_enu[1]);
  EXPECT_TRUE(georeference(segments.drive, with_gnss(), false).newly_aligned);
  for (const int segment : {0, 1}) EXPECT_TRUE(segments.is_at(segment, Pose(), 1e-6)) << segment;
  EXPECT_EQ(segments.drive.in_enu, (std::vector<bool>{true, true}));
}

TEST(Georeferencing, KeepsWhatJoinsASegmentInEastNorthUp) {
  Segments segments({Pose(), Pose()});
  for (const int segment : {0, 1}) segments.add_gnss_to_segment(segment);
  segments.drive.in_enu = {true, true};
  segments.add_loop(4, kSegmentNodes + 4);
  connect_segments(segments.drive);
  EXPECT_EQ(segments.drive.in_enu, (std::vector<bool>{true, true}));
}

TEST(Georeferencing, AlignsTheBeginningIfTheWholeTrackHasDriftedTooFar) {
  Segments segments({kElsewhere});
  segments.add_gnss_to_segment(0);
  // Behind the first sixteen nodes the track bends further and further off: most positions disagree
  // with any one alignment.
  Pose bend = kElsewhere;
  for (int i = 16; i < kSegmentNodes; ++i) {
    const Pose drift{exp_so3({0.0, 0.0, 0.15}), {6.0, 0.0, 0.0}};
    bend = bend * drift;
    segments.drive.nodes[i].T_map_base = bend * segments.truth(i);
  }
  EXPECT_TRUE(georeference(segments.drive, with_gnss(), false).newly_aligned);
  for (int i = 0; i < 16; ++i) {
    const Pose& found = segments.drive.nodes[i].T_map_base;
    EXPECT_TRUE(test::near(found, segments.truth(i), 1e-3)) << i;
  }
}

/// The states of the nodes, with a drift that grows with the way.
pose_graph::FactorGraph drifted_states(const Segments& segments, const Vector6d& drift_per_node) {
  pose_graph::FactorGraph graph;
  Pose drift;
  for (const DriveNode& node : segments.drive.nodes) {
    graph.add_node(drift * node.T_map_base);
    drift = perturbed(drift, drift_per_node);
  }
  return graph;
}

TEST(ShiftToGnss, MovesEachSectionOntoThePositionsNearIt) {
  Segments segments(std::vector<Pose>(12, Pose()));
  for (int s = 0; s < 12; ++s) {
    segments.add_gnss_to_segment(s);
    segments.drive.in_enu[s] = true;
  }
  Vector6d drift = Vector6d::Zero();
  drift << 0.05, 0.02, 0.005, 0.0, 0.0, 0.0001;
  pose_graph::FactorGraph graph = drifted_states(segments, drift);
  const int last = static_cast<int>(segments.drive.nodes.size()) - 1;
  ASSERT_GT((graph.pose(last).translation - segments.truth(last).translation).norm(), 20.0);
  shift_to_gnss(segments.drive, with_gnss(), graph);
  // A section drifts by 6 m from its first to its last position.
  for (int i = 0; i <= last; ++i) {
    EXPECT_TRUE(test::near(graph.pose(i).translation, segments.truth(i).translation, 4.0)) << i;
  }
}

TEST(ShiftToGnss, LeavesSegmentsThatAreNotAligned) {
  Segments segments({Pose(), kFarAway, Pose()});
  for (const int s : {0, 2}) segments.add_gnss_to_segment(s);
  segments.drive.in_enu = {true, false, true};
  const Pose shift{exp_so3({0.0, 0.0, 0.1}), {5.0, 3.0, 1.0}};
  pose_graph::FactorGraph graph;
  for (const DriveNode& node : segments.drive.nodes) graph.add_node(shift * node.T_map_base);
  shift_to_gnss(segments.drive, with_gnss(), graph);
  for (int i = 0; i < 3 * kSegmentNodes; ++i) {
    const bool is_aligned = i / kSegmentNodes != 1;
    const Pose expected = is_aligned ? segments.truth(i) : shift * kFarAway * segments.truth(i);
    EXPECT_TRUE(test::near(graph.pose(i), expected, 1e-6)) << i;
  }
}

}  // namespace
}  // namespace lidar_mapping::back_end
