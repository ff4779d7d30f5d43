// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <ctime>

#include <gtest/gtest.h>

#include "candidates/candidate_generator.hpp"
#include "drive.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

class NoClouds : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex) override { return nullptr; }
};

/// Indices of the key frames at which a search was made. There are no clouds: each attempt ends
/// undecided and does not influence the next searches.
std::vector<std::size_t> attempts(const std::vector<Pose>& poses,
                                  const LoopClosingConfig& config = {}) {
  NoClouds clouds;
  LoopCloser closer(config, clouds);
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!closer.process(key_frame(i, poses[i])).verdicts.empty()) result.push_back(i);
  }
  return result;
}

/// The first key frame with an older one within 7 m and at least 50 m of path length before it.
std::size_t first_possible(const std::vector<Pose>& poses, double step) {
  const auto gap = static_cast<std::size_t>(std::ceil(50.0 / step));
  for (std::size_t i = gap; i < poses.size(); ++i) {
    for (std::size_t j = 0; j + gap <= i; ++j) {
      if ((poses[i].translation - poses[j].translation).norm() < 7.0) return i;
    }
  }
  return poses.size();
}

// A street that is driven back is found in time, whatever the length of the drive.
TEST(Candidates, AreMatchedWithinTenKeyFramesOfTheFirstPossibility) {
  for (double length = 200.0; length < 310.0; length += 9.0) {
    const auto poses =
        along({{0, 0}, {length, 0}, {length, 4}, {length - 140.0, 4}, {length - 140.0, 300}});
    const auto tried = attempts(poses);
    ASSERT_FALSE(tried.empty()) << length;
    EXPECT_LE(tried.front(), first_possible(poses, 2.0) + 10) << length;
  }
}

// The spacing of key frames is arbitrary.
TEST(Candidates, DoNotDependOnTheSpacingOfKeyFrames) {
  for (const double step : {0.5, 2.0, 5.0}) {
    const auto poses = along({{0, 0}, {150, 0}, {150, 150}, {0, 150}, {0, 0}, {100, 0}}, step);
    const auto tried = attempts(poses);
    ASSERT_FALSE(tried.empty()) << step;
    EXPECT_NEAR(static_cast<double>(tried.front()) * step, 592.0, 12.0) << step;
    EXPECT_GE(static_cast<double>(tried.back()) * step, 685.0) << step;
  }
}

TEST(Candidates, LoopStepAndMinEdgeIntervalSetTheSpacingOfSearches) {
  const auto poses = along({{0, 0}, {100, 0}, {100, 4}, {0, 4}});
  LoopClosingConfig config;
  config.loop_step = 5;
  const auto tried = attempts(poses, config);
  ASSERT_GE(tried.size(), 3U);
  for (std::size_t i = 1; i < tried.size(); ++i) EXPECT_GE(tried[i] - tried[i - 1], 5U);

  // After a loop, the next search waits for the interval: here 30 m, 15 key frames.
  const auto searches_after_a_loop = [&](double interval) {
    LoopClosingConfig waiting;
    waiting.min_edge_interval = interval;
    NoClouds clouds;
    LoopCloser closer(waiting, clouds);
    const std::size_t last = 75;
    for (std::size_t i = 0; i <= last; ++i) closer.restore(key_frame(i, poses[i]));
    Loop loop;
    loop.from = 10;
    loop.to = last;
    closer.restore({loop}, {}, {});
    for (std::size_t i = last + 1; i < poses.size(); ++i) {
      if (!closer.process(key_frame(i, poses[i])).verdicts.empty()) return i - last;
    }
    return std::size_t{0};
  };
  EXPECT_EQ(searches_after_a_loop(0.0), 1U);
  EXPECT_EQ(searches_after_a_loop(30.0), 15U);
}

/// Back through the same street 8 m beside, with an odometry that does not drift: nothing but this
/// radius admits a candidate.
TEST(Candidates, DetectAreaIsTheRadiusWherePositionsAreCertain) {
  const auto poses = along({{0, 0}, {100, 0}, {100, 8}, {0, 8}});
  LoopClosingConfig config;
  config.horizontal_drift = 0.0;
  config.max_loop_distance = 50.0;
  config.detect_area = 7.0;
  EXPECT_TRUE(attempts(poses, config).empty());
  config.detect_area = 9.0;
  EXPECT_FALSE(attempts(poses, config).empty());
}

TEST(Candidates, DiffNumAndAccumDistanceThreshExcludeNeighbours) {
  const auto poses = along({{0, 0}, {100, 0}, {100, 4}, {0, 4}});
  LoopClosingConfig config;
  config.diff_num = 90;
  EXPECT_GE(attempts(poses, config).front(), 90U);
  config.diff_num = 0;
  config.accum_distance_thresh = 190.0;
  EXPECT_GE(attempts(poses, config).front(), 95U);
}

TEST(Candidates, DistanceThreshLimitsTheRadius) {
  const auto poses = along({{0, 0}, {200, 0}, {200, 12}, {0, 12}});
  LoopClosingConfig config;
  config.max_loop_distance = 20.0;
  EXPECT_FALSE(attempts(poses, config).empty());
  config.distance_thresh = 5.0;
  const auto tried = attempts(poses, config);
  EXPECT_TRUE(tried.empty() || tried.front() > poses.size());
}

TEST(Candidates, EverySourceCanBeSwitchedOff) {
  const auto poses = along({{0, 0}, {100, 0}, {100, 4}, {0, 4}});
  LoopClosingConfig config;
  config.position_candidates = false;
  EXPECT_TRUE(attempts(poses, config).empty());
}

// Its duration grows with the region that the drift since then admits, not with the square of the
// drive: 25 us among 2,000 key frames, 0.2 ms among 10,000.
TEST(Candidates, AreFoundInLessThanAMillisecondAmongTenThousandKeyFrames) {
  CandidateGenerator places{LoopClosingConfig()};
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < 20; ++row) {
    corners.emplace_back(row % 2 == 0 ? 0.0 : 1000.0, 50.0 * row);
    corners.emplace_back(row % 2 == 0 ? 1000.0 : 0.0, 50.0 * row);
  }
  const auto poses = along(corners, 2.0);
  ASSERT_GT(poses.size(), 10000U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    places.append(key_frame(i, poses[i]), std::nullopt);
  }
  // The shortest of several durations, because other load only adds to it.
  double seconds = 1.0;
  for (int i = 0; i < 50; ++i) {
    const std::clock_t begin = std::clock();
    places.candidates();
    seconds = std::min(seconds, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  EXPECT_LT(seconds, 1e-3);
}

/// Two streets 60 m apart; by odometry the second one is a new street.
std::vector<Pose> two_streets() { return along({{0, 0}, {200, 0}, {200, 60}, {0, 60}}); }

// A correction of the map changes which key frames are near.
TEST(Candidates, FollowTheCorrectedMap) {
  LoopClosingConfig config;
  config.horizontal_drift = 0.0;
  CandidateGenerator places(config);
  const auto poses = two_streets();
  KeyFramePoses corrected{1, true, {}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    places.append(key_frame(i, poses[i]), std::nullopt);
    Pose pose = poses[i];
    pose.translation.y() *= 0.05;
    corrected.poses.push_back({static_cast<KeyFrameIndex>(i), 0, pose});
  }
  EXPECT_TRUE(places.candidates().empty());
  places.update_poses(corrected);
  const auto candidates = places.candidates();
  ASSERT_FALSE(candidates.empty());
  EXPECT_LE(candidates.front().node, 3U);
}

// Key frames on different storeys are not near each other.
TEST(Candidates, AreNotOnAnotherStorey) {
  LoopClosingConfig config;
  config.vertical_drift = 0.001;
  CandidateGenerator places(config);
  auto poses = along({{0, 0}, {60, 0}, {60, 20}, {0, 20}, {0, 0}, {60, 0}});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 80) poses[i].translation.z() = 6.0;
    places.append(key_frame(i, poses[i]), std::nullopt);
  }
  EXPECT_TRUE(places.candidates().empty());
}

GnssPosition position_at(std::size_t i, const Pose& T_enu_base) {
  GnssPosition position;
  position.stamp = key_frame(i, {}).stamp;
  position.p_enu_antenna = T_enu_base.translation;
  position.covariance = 0.25 * Eigen::Matrix3d::Identity();
  return position;
}

/// Candidates at the end of a round of 800 m with a receiver of any height, whose positions come
/// before or after their key frames.
std::vector<Candidate> candidates_after_a_round(const LoopClosingConfig& config) {
  CandidateGenerator places(config);
  const auto truth = along({{0, 0}, {300, 0}, {300, 100}, {0, 100}, {0, 0}});
  for (std::size_t i = 0; i < truth.size(); ++i) {
    GnssPosition position = position_at(i, truth[i]);
    position.p_enu_antenna.z() = i % 7 == 0 ? 15.0 : 0.0;
    if (i % 2 == 0) places.add_gnss(position);
    places.append(key_frame(i, truth[i]), std::nullopt);
    if (i % 2 == 1) places.add_gnss(position);
  }
  return places.candidates();
}

TEST(Candidates, ComeFromGnssIfOdometryIsWrong) {
  LoopClosingConfig config;
  config.position_candidates = false;
  config.accum_distance_thresh = 100.0;
  const auto candidates = candidates_after_a_round(config);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates.front().source, LoopSource::kGnss);
  config.gnss_candidates = false;
  EXPECT_TRUE(candidates_after_a_round(config).empty());
}

// The distance travelled stands still between two segments, which may be anywhere.
TEST(Candidates, AtTheEndOfASegmentAndTheBeginOfTheNextAreBothMatched) {
  NoClouds clouds;
  LoopCloser closer({}, clouds);
  const std::vector<Pose> poses = {
      planar(-4.0, 0.0, 0.0), planar(-2.0, 0.0, 0.0), planar(0.0, 0.0, 0.0), planar(0.0, 2.0, 0.0),
      planar(2.0, 2.0, 0.0),  planar(4.0, 2.0, 0.0),  planar(0.0, 1.0, 0.0)};
  std::vector<LoopVerdict> verdicts;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    closer.add_gnss(position_at(i, poses[i]));
    KeyFrame key = key_frame(i, poses[i]);
    key.segment = static_cast<std::uint32_t>(i / 3);
    if (i < 6) {
      closer.restore(key);
    } else {
      verdicts = closer.process(key).verdicts;
    }
  }
  ASSERT_EQ(verdicts.size(), 2U);
  EXPECT_EQ(verdicts[0].from, 2U);
  EXPECT_EQ(verdicts[1].from, 3U);
}

TEST(Candidates, AreMoreCertainByLoopsThatTheMapSatisfies) {
  LoopClosingConfig config;
  config.max_loop_distance = 30.0;
  CandidateGenerator places(config);
  const auto poses = along({{0, 0}, {500, 0}, {500, 25}, {0, 25}});
  KeyFramePoses whole{1, true, {}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    places.append(key_frame(i, poses[i]), std::nullopt);
    whole.poses.push_back({static_cast<KeyFrameIndex>(i), 0, poses[i]});
  }
  Loop loop;
  loop.from = 1;
  loop.to = static_cast<KeyFrameIndex>(poses.size() - 2);
  loop.T_from_to = poses[loop.from].inverse() * poses[loop.to];
  const auto radius_admits = [&] {
    places.update_poses(whole);
    return !places.candidates().empty();
  };
  EXPECT_TRUE(radius_admits());
  places.add_loop(loop);
  EXPECT_FALSE(radius_admits());
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
