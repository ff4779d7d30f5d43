// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/loop_closing/pair_match.hpp"

#include "drive.hpp"
#include "error_text.hpp"
#include "near.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

using lidar_mapping::test::near;

/// The clouds of a drive, of which some are lost.
class IncompleteClouds : public CloudSource {
 public:
  IncompleteClouds(CloudSource& clouds, std::set<KeyFrameIndex> lost)
      : clouds_(clouds), lost_(std::move(lost)) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    return lost_.count(index) > 0 ? nullptr : clouds_.cloud(index);
  }

 private:
  CloudSource& clouds_;
  std::set<KeyFrameIndex> lost_;
};

/// Along a street and back on the other lane.
std::vector<Pose> there_and_back() {
  std::vector<Pose> poses = along({{-20.0, 0.0}, {20.0, 0.0}});
  for (const Pose& pose : along({{20.0, 2.0}, {-20.0, 2.0}})) poses.push_back(pose);
  return poses;
}

/// The clouds of that drive, each simulated once for all tests.
class StreetClouds : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex index) override {
    PointCloudPtr& cloud = clouds_[index];
    if (!cloud) cloud = simulated_.cloud(index);
    return cloud;
  }

 private:
  ToyWorld world_ = make_town(70.0, 100.0, 6);
  DriveClouds simulated_{world_, there_and_back()};
  std::map<KeyFrameIndex, PointCloudPtr> clouds_;
};

StreetClouds& street_clouds() {
  static StreetClouds clouds;
  return clouds;
}

/// The drive, whose odometry is lost by 30 m at the turn.
class PairMatch : public testing::Test {
 protected:
  PairMatch() : truth_(there_and_back()) {
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const Pose lost = i < truth_.size() / 2 ? Pose() : planar(-10.0, 30.0, 0.5);
      key_frames_.push_back(key_frame(i, lost * truth_[i]));
    }
  }

  static KeyFrameIndex from() { return 9; }
  static KeyFrameIndex to() { return 31; }
  Pose true_motion() const { return truth_[from()].inverse() * truth_[to()]; }
  loop_closing::PairMatch match(const std::optional<Pose>& guess, KeyFrameIndex older = from(),
                                KeyFrameIndex newer = to()) {
    return match_pair({}, street_clouds(), ToyWorld::sensor(), key_frames_, older, newer, guess);
  }
  std::string error(KeyFrameIndex older, KeyFrameIndex newer) {
    return lidar_mapping::test::error_text<InputError>([&] { match(std::nullopt, older, newer); });
  }

  std::vector<Pose> truth_;
  std::vector<KeyFrame> key_frames_;
};

// The other lane, the other direction, and an estimate that is 30 m off.
TEST_F(PairMatch, FindsThePoseByTheViewsWithoutAGuess) {
  const auto result = match(std::nullopt);
  ASSERT_TRUE(result.loop.has_value()) << result.verdict.reason;
  EXPECT_TRUE(near(result.loop->T_from_to, true_motion(), 0.1, 0.01));
  EXPECT_EQ(result.loop->from, from());
  EXPECT_EQ(result.loop->to, to());
  EXPECT_EQ(result.loop->stamp, key_frames_[to()].stamp);
  EXPECT_EQ(result.loop->source, LoopSource::kManual);
  EXPECT_EQ(result.verdict.verdict, Verdict::kAccepted);
  EXPECT_EQ(result.verdict.source, LoopSource::kManual);
}

TEST_F(PairMatch, StartsAtTheGuess) {
  const auto result = match(true_motion() * planar(0.8, -0.5, 0.04));
  ASSERT_TRUE(result.loop.has_value()) << result.verdict.reason;
  EXPECT_TRUE(near(result.loop->T_from_to, true_motion(), 0.1, 0.01));
  EXPECT_TRUE(is_valid_covariance(result.loop->covariance));
}

TEST_F(PairMatch, TakesNoGuessThatIsFarOff) {
  const auto result = match(true_motion() * planar(25.0, 14.0, 1.5));
  EXPECT_FALSE(result.loop.has_value());
  EXPECT_NE(result.verdict.verdict, Verdict::kAccepted);
  EXPECT_FALSE(result.verdict.reason.empty());
  EXPECT_EQ(result.verdict.from, from());
  EXPECT_EQ(result.verdict.to, to());
}

// A person may look at a part of a drive: what comes later does not count.
TEST_F(PairMatch, DoesNotDependOnLaterKeyFrames) {
  const auto whole = match(std::nullopt);
  key_frames_.resize(to() + 1);
  const auto part = match(std::nullopt);
  ASSERT_TRUE(whole.loop.has_value());
  ASSERT_TRUE(part.loop.has_value());
  EXPECT_EQ(part.loop->T_from_to.translation, whole.loop->T_from_to.translation);
  EXPECT_EQ(part.loop->covariance, whole.loop->covariance);
}

TEST_F(PairMatch, SaysWhichKeyFrameIsUnknown) {
  EXPECT_NE(error(from(), 700).find("there is no key frame 700"), std::string::npos)
      << error(from(), 700);
  EXPECT_NE(error(700, to()).find("there is no key frame 700"), std::string::npos);
}

TEST_F(PairMatch, RefusesKeyFramesThatShareClouds) {
  const std::string text = error(30, 31);
  EXPECT_NE(text.find("30 and 31"), std::string::npos) << text;
  EXPECT_NE(text.find("too near"), std::string::npos) << text;
  EXPECT_NE(error(31, 31), "") << "with itself";
  EXPECT_NE(error(31, 9), "") << "the older one comes first";
}

TEST_F(PairMatch, SaysThatACloudIsLost) {
  for (const KeyFrameIndex lost : {from(), to()}) {
    IncompleteClouds clouds(street_clouds(), {lost});
    const auto result =
        match_pair({}, clouds, ToyWorld::sensor(), key_frames_, from(), to(), true_motion());
    if (lost == from() && result.loop) {
      // The clouds around make a submap without it.
      EXPECT_TRUE(near(result.loop->T_from_to, true_motion(), 0.1, 0.01));
      continue;
    }
    EXPECT_FALSE(result.loop.has_value()) << lost;
    EXPECT_EQ(result.verdict.from, from());
    EXPECT_EQ(result.verdict.to, to());
    EXPECT_EQ(result.verdict.stamp, key_frames_[to()].stamp);
    EXPECT_EQ(result.verdict.source, LoopSource::kManual);
    EXPECT_NE(result.verdict.reason.find("cloud"), std::string::npos) << result.verdict.reason;
  }
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
