// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/ros/pose_feed.hpp"

#include "back_end/back_end_fixture.hpp"
#include "back_end/sent_poses.hpp"
#include "near.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Indices = std::vector<KeyFrameIndex>;

/// Key frames on a line, 2 m apart; every second index is missing, as of key frames that never
/// came.
KeyFramePoses on_a_line(std::size_t count, std::uint32_t revision = 1) {
  KeyFramePoses poses;
  poses.revision = revision;
  for (std::size_t i = 0; i < count; ++i) {
    KeyFramePose pose;
    pose.index = static_cast<KeyFrameIndex>(2 * i);
    pose.stamp = static_cast<Stamp>(100 * i);
    pose.T_map_base.translation.x() = 2.0 * static_cast<double>(i);
    poses.poses.push_back(pose);
  }
  return poses;
}

Indices indices_of(const std::optional<KeyFramePoses>& poses) {
  Indices result;
  if (poses) {
    for (const KeyFramePose& pose : poses->poses) result.push_back(pose.index);
  }
  return result;
}

/// Subscribers have been sent the first solution of ten key frames.
class SentPosesOfARun : public testing::Test {
 protected:
  SentPosesOfARun() { first_ = sent_.update(now_, false); }

  std::optional<KeyFramePoses> next(bool whole = false) {
    ++now_.revision;
    return sent_.update(now_, whole);
  }
  Pose& pose(std::size_t i) { return now_.poses[i].T_map_base; }

  SentPoses sent_;
  KeyFramePoses now_ = on_a_line(10);
  std::optional<KeyFramePoses> first_;
};

TEST_F(SentPosesOfARun, AreAllSentAtFirst) {
  ASSERT_TRUE(first_);
  EXPECT_TRUE(first_->whole);
  EXPECT_EQ(first_->revision, 1U);
  EXPECT_EQ(first_->poses.size(), 10U);
}

TEST_F(SentPosesOfARun, AreSentAgainWhereTheyMoved) {
  pose(3).translation.y() += 0.01;
  pose(7).rotation = exp_so3({0.0, 0.0, 0.001});
  const auto part = next();
  ASSERT_EQ(indices_of(part), (Indices{6, 14}));
  EXPECT_FALSE(part->whole);
  EXPECT_EQ(part->revision, 2U);
  EXPECT_EQ(part->since, 1U);
  EXPECT_EQ(part->poses[0].T_map_base.translation.y(), 0.01);
  EXPECT_EQ(part->poses[1].stamp, 700);
}

TEST_F(SentPosesOfARun, AreNotSentForAMoveThatNobodySees) {
  pose(3).translation.y() += 0.0009;
  pose(7).rotation = exp_so3({0.0, 0.0, 0.00009});
  EXPECT_FALSE(next());
  EXPECT_EQ(sent_.all().poses[3].T_map_base.translation.y(), 0.0) << "others know no other pose";
}

// Else subscribers would have a map that is wrong by the sum of all small moves.
TEST_F(SentPosesOfARun, AreSentWhenSmallMovesHaveAddedUp) {
  for (int i = 0; i < 2; ++i) {
    pose(3).translation.y() += 0.0004;
    EXPECT_FALSE(next()) << i;
  }
  pose(3).translation.y() += 0.0004;
  const auto part = next();
  EXPECT_EQ(indices_of(part), (Indices{6}));
  EXPECT_EQ(part->since, 1U) << "nothing was sent in between";
  EXPECT_EQ(part->revision, 4U);
}

TEST_F(SentPosesOfARun, AreSentOfNewKeyFrames) {
  const std::uint32_t revision = now_.revision;
  now_ = on_a_line(12, revision);
  EXPECT_EQ(indices_of(next()), (Indices{20, 22}));
  EXPECT_FALSE(next()) << "they have been sent";
}

TEST_F(SentPosesOfARun, AreAllSentIfAllMovedOrOnRequest) {
  for (auto& entry : now_.poses) entry.T_map_base.translation.z() += 1.0;
  const auto moved = next();
  ASSERT_TRUE(moved);
  EXPECT_TRUE(moved->whole);
  EXPECT_EQ(moved->revision, 2U);
  EXPECT_EQ(moved->poses.size(), 10U);
  pose(3).translation.y() += 0.0005;
  const auto asked = next(true);
  ASSERT_TRUE(asked);
  EXPECT_TRUE(asked->whole);
  EXPECT_EQ(asked->revision, 3U);
  EXPECT_EQ(asked->poses[3].T_map_base.translation.y(), 0.0005) << "exact on request";
}

// After a solution that failed; subscribers would take such a message for an outdated one.
TEST_F(SentPosesOfARun, WaitForTheNextRevision) {
  now_ = on_a_line(11, now_.revision);
  EXPECT_FALSE(sent_.update(now_, false));
  EXPECT_EQ(indices_of(next()), (Indices{20}));
}

TEST_F(SentPosesOfARun, AreGivenToANewSubscriberAsTheOthersKnowThem) {
  pose(3).translation.y() += 0.5;
  pose(4).translation.y() += 0.0005;
  next();
  EXPECT_TRUE(sent_.all().whole);
  EXPECT_EQ(sent_.all().revision, 2U);
  EXPECT_EQ(sent_.all().poses.size(), 10U);
  EXPECT_EQ(sent_.all().poses[3].T_map_base.translation.y(), 0.5);
  EXPECT_EQ(sent_.all().poses[4].T_map_base.translation.y(), 0.0);
}

TEST_F(SentPosesOfARun, BeginAnewWithAnotherRun) {
  sent_.clear();
  EXPECT_TRUE(sent_.all().poses.empty());
  EXPECT_FALSE(sent_.update({}, true)) << "no key frame yet";
  const auto all = sent_.update(on_a_line(2), false);
  ASSERT_TRUE(all);
  EXPECT_TRUE(all->whole);
}

TEST_F(SentPosesOfARun, AreAllSentIfTheKeyFramesAreOthers) {
  const std::uint32_t revision = now_.revision;
  now_ = on_a_line(9, revision);
  const auto fewer = next();
  ASSERT_TRUE(fewer);
  EXPECT_TRUE(fewer->whole);
  now_.poses[4].index = 9;
  const auto renumbered = next();
  ASSERT_TRUE(renumbered);
  EXPECT_TRUE(renumbered->whole);
}

/// 4400 key frames in eleven laps around a street block, connected by loops and solved.
class SentPosesOfALongDrive : public testing::Test {
 protected:
  SentPosesOfALongDrive() {
    test::DriveSettings settings;
    settings.laps = 11;
    settings.turn_bias_deg = 0.001;
    drive_ = test::make_drive(settings);
    test::feed(back_end_, drive_);
    test::add_lap_loops(back_end_, drive_, 400, 10, engine_);
    EXPECT_TRUE(test::optimize(back_end_).success);
  }

  test::SyntheticDrive drive_;
  back_end::BackEnd back_end_{back_end::BackEndConfig{}};
  std::mt19937 engine_{11};
};

// Messages grew with the drive: all poses were sent after each solution.
TEST_F(SentPosesOfALongDrive, AreFewAfterASolutionOfAWindow) {
  SentPoses sent;
  PoseFeed subscriber([] {
    ADD_FAILURE() << "no message is missing";
    return std::optional<RunPoses>();
  });
  subscriber.push({"run", *sent.update(back_end_.poses(), false)});
  for (const int from : {2005, 2805, 1605}) {
    back_end_.add_loop(test::make_loop(drive_, from, from + 400, engine_));
    ASSERT_TRUE(test::optimize(back_end_).success);
    const auto part = sent.update(back_end_.poses(), false);
    ASSERT_TRUE(part);
    EXPECT_FALSE(part->whole);
    EXPECT_LT(part->poses.size(), 1500U) << "the window, of 4400 key frames";
    subscriber.push({"run", *part});
  }
  const KeyFramePoses exact = back_end_.poses();
  const KeyFramePoses known = subscriber.known("run");
  ASSERT_EQ(known.poses.size(), exact.poses.size());
  for (std::size_t i = 0; i < exact.poses.size(); ++i) {
    EXPECT_EQ(known.poses[i].index, exact.poses[i].index);
    EXPECT_TRUE(test::near(known.poses[i].T_map_base.translation,
                           exact.poses[i].T_map_base.translation, 0.001));
  }
}

}  // namespace
}  // namespace lidar_mapping::ros_border
