// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "loop_search.hpp"
#include "temporary_folder.hpp"
#include "town_session.hpp"

namespace lidar_mapping::pipeline::test {
namespace {

using lidar_mapping::test::TemporaryFolder;
using session::Session;
using Pairs = std::set<std::pair<KeyFrameIndex, KeyFrameIndex>>;

/// A street that is driven through again a day later, in a segment of its own. Odometry does not
/// connect it to the one before, so matches between both wait until others agree with them.
class LoopSearchTest : public ::testing::Test {
 protected:
  static loop_closing::LoopClosingConfig config() {
    loop_closing::LoopClosingConfig config;
    config.unanchored_path_length = 20.0;  // m, so that the street is long enough
    return config;
  }

  /// One run: what the pipeline does with key frames, without its threads.
  struct Run {
    explicit Run(Session session, const loop_closing::LoopClosingConfig& settings = config())
        : back_end(std::move(session), {}), search(settings, back_end.session(), feedback) {}

    void add(KeyFrame key_frame, const std::optional<GnssPosition>& gnss = std::nullopt) {
      back_end.session().clouds().put(key_frame.index, key_frame.cloud);
      DriveChunk chunk;
      chunk.scans.emplace_back().gnss = gnss;
      if (gnss) back_end.add_gnss(*gnss);
      chunk.key_frame = std::move(key_frame);
      search.process(chunk);
      feedback.add_step(nullptr);
      back_end.add_key_frame(*chunk.key_frame);
      for (const Loop& loop : chunk.loops) {
        EXPECT_TRUE(found.emplace(loop.from, loop.to).second) << "only once";
        back_end.add_loop(loop);
      }
      for (const LoopVerdict& verdict : chunk.verdicts) back_end.add_verdict(verdict);
    }
    bool has_waiting_match() const {
      const std::vector<LoopVerdict> verdicts = back_end.session().verdicts();
      return std::any_of(verdicts.begin(), verdicts.end(), is_waiting);
    }

    RecordedBackEnd back_end;
    PoseFeedback feedback;
    LoopSearch search;
    Pairs found;
  };

  Stamp stamp(std::size_t i) const {
    return kStart + from_seconds(static_cast<double>(i) + (i >= mapped_ ? 86400.0 : 0.0));
  }

  KeyFrame key_frame(std::size_t i) const {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    const bool is_again = i >= mapped_;
    key_frame.stamp = stamp(i);
    key_frame.segment = is_again ? 1 : 0;
    key_frame.T_odom_base = is_again ? truth_[mapped_].inverse() * truth_[i] : truth_[i];
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    key_frame.cloud =
        std::make_shared<const PointCloud>(world_.scan(truth_[i], static_cast<std::uint32_t>(i)));
    return key_frame;
  }

  GnssPosition position(std::size_t i) const {
    GnssPosition position;
    position.stamp = stamp(i);
    position.p_enu_antenna = truth_[i].translation;
    position.covariance = 0.01 * Eigen::Matrix3d::Identity();
    return position;
  }

  const ToyWorld world_ = make_town(80.0, 100.0, 2);
  const std::size_t mapped_ = along({{-50, 0}, {50, 0}}).size();
  const std::vector<Pose> truth_ = along({{-50, 0}, {50, 0}, {-50, 0}});
};

TEST_F(LoopSearchTest, FindsMatchesAgainThatWaitedWhenTheDriveWasBrokenOff) {
  const TemporaryFolder whole, broken;
  Run uninterrupted(Session::create_in(whole.path()));
  for (std::size_t i = 0; i < truth_.size(); ++i) uninterrupted.add(key_frame(i));
  ASSERT_GT(uninterrupted.found.size(), 1U);

  std::size_t next = 0;
  {
    Run run(Session::create_in(broken.path()));
    while (next < truth_.size() && !run.has_waiting_match()) run.add(key_frame(next++));
    ASSERT_TRUE(run.has_waiting_match());
    ASSERT_TRUE(run.found.empty());
  }
  Run run(Session::open(broken.path(), Session::Access::kWrite));
  run.search.restore(run.back_end);
  for (; next < truth_.size(); ++next) run.add(key_frame(next));
  EXPECT_EQ(run.found, uninterrupted.found);
}

// The vehicle stood for some minutes at the end, where every scan has a position.
TEST_F(LoopSearchTest, KnowsThePositionsOfKeyFramesThatAreSearchedAgain) {
  const TemporaryFolder folder;
  {
    Run run(Session::create_in(folder.path()));
    for (std::size_t i = 0; i < mapped_; ++i) run.add(key_frame(i), position(i));
    for (int i = 1; i <= 3000; ++i) {
      GnssPosition standing = position(mapped_ - 1);
      standing.stamp += from_seconds(0.1 * i);
      run.back_end.add_gnss(standing);
    }
    Loop open;
    open.to = 5;
    run.back_end.add_verdict(verdict_on(open, Verdict::kUndecided, waiting_reason(20.0)));
  }
  loop_closing::LoopClosingConfig by_gnss_alone = config();
  by_gnss_alone.position_candidates = false;
  by_gnss_alone.appearance_candidates = false;
  Run run(Session::open(folder.path(), Session::Access::kWrite), by_gnss_alone);
  run.search.restore(run.back_end);
  for (std::size_t i = mapped_; i < truth_.size(); ++i) run.add(key_frame(i), position(i));
  EXPECT_TRUE(std::any_of(run.found.begin(), run.found.end(),
                          [](const auto& pair) { return pair.first > 20; }))
      << "a pair in the middle of the street, of " << run.found.size();
}

}  // namespace
}  // namespace lidar_mapping::pipeline::test
