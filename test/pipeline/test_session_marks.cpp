// SPDX-License-Identifier: BSD-3-Clause
#include <optional>

#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/session_marks.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using session::Session;
using test::TemporaryFolder;

Stamp stamp_of(KeyFrameIndex index) { return from_seconds(1000.0 + index); }

/// Six key frames, 10 m and a second apart, in two segments; the first two close a loop with the
/// last.
class SessionMarks : public testing::Test {
 protected:
  SessionMarks() : session_(Session::create_in(folder_.path() / "session")) {
    for (KeyFrameIndex i = 0; i < 6; ++i) {
      KeyFrame key_frame;
      key_frame.index = i;
      key_frame.segment = i / 3;
      key_frame.stamp = stamp_of(i);
      session_.add_key_frame(key_frame);
      Pose pose;
      pose.translation.x() = 10.0 * i;
      poses_.poses.push_back({i, key_frame.stamp, pose});
    }
    for (const KeyFrameIndex from : {0U, 1U}) {
      Loop loop;
      loop.from = from;
      loop.to = 5;
      loop.source = LoopSource::kAppearance;
      session_.add_loop(loop);
    }
    LoopVerdict verdict;
    verdict.to = 5;
    verdict.verdict = Verdict::kAccepted;
    session_.add_verdict(verdict);
    verdict.verdict = Verdict::kRefused;
    verdict.reason = "it contradicts the others";
    session_.add_verdict(verdict);
  }

  void write_doubtful_section(double begin_s, double end_s,
                              std::optional<KeyFrameRange> key_frames) {
    DriveDoubt doubt;
    DoubtfulSection section;
    section.doubt = Doubt::kDegenerate;
    section.begin = from_seconds(1000.0 + begin_s);
    section.end = from_seconds(1000.0 + end_s);
    section.position = {10.0 * begin_s, 0.0, 0.0};
    section.path_length = 12.0;
    section.expected_error = 0.5;
    section.is_trusted = false;
    section.key_frames = key_frames;
    doubt.begin = stamp_of(0);
    doubt.sections = {section};
    write_doubt(doubt, session_.directory() / "doubt.csv");
  }

  const TemporaryFolder folder_;
  Session session_;
  KeyFramePoses poses_;
};

TEST_F(SessionMarks, HaveThePathWithItsSegments) {
  const DriveMarks marks = session_marks(session_, poses_);
  ASSERT_EQ(marks.path.size(), 6U);
  EXPECT_EQ(marks.path[2].segment, 0U);
  EXPECT_EQ(marks.path[3].segment, 1U);
  EXPECT_EQ(marks.path[3].stamp, stamp_of(3));
  EXPECT_EQ(marks.path[3].p_map.x(), 30.0);
  EXPECT_TRUE(marks.doubts.empty()) << "without doubt.csv there is no doubt";
}

TEST_F(SessionMarks, HaveTheNewestVerdictOfEachLoop) {
  const DriveMarks marks = session_marks(session_, poses_);
  ASSERT_EQ(marks.loops.size(), 2U);
  EXPECT_EQ(marks.loops[0].verdict, Verdict::kRefused);
  EXPECT_EQ(marks.loops[0].reason, "it contradicts the others");
  EXPECT_EQ(marks.loops[0].source, LoopSource::kAppearance);
  EXPECT_EQ(marks.loops[1].verdict, Verdict::kUndecided) << "nobody has judged it yet";
}

TEST_F(SessionMarks, LeaveOutLoopsOfKeyFramesWithoutAPose) {
  poses_.poses.erase(poses_.poses.begin());
  const DriveMarks marks = session_marks(session_, poses_);
  ASSERT_EQ(marks.loops.size(), 1U);
  EXPECT_EQ(marks.loops[0].from, 1U);
}

// A doubtful section may have no key frame at all: then it leads to the next one.
TEST_F(SessionMarks, FollowThePathThroughADoubtfulSection) {
  write_doubtful_section(1.5, 3.5, KeyFrameRange{1, 4});
  DoubtMark doubt = session_marks(session_, poses_).doubts.at(0);
  EXPECT_EQ(doubt.kind, "degenerate");
  EXPECT_FALSE(doubt.is_trusted);
  EXPECT_EQ(doubt.expected_error, 0.5);
  ASSERT_EQ(doubt.path_map.size(), 4U);
  EXPECT_EQ(doubt.path_map[0].x(), 15.0);
  EXPECT_EQ(doubt.path_map[3].x(), 40.0);

  write_doubtful_section(1.2, 1.4, KeyFrameRange{1, 2});
  doubt = session_marks(session_, poses_).doubts.at(0);
  ASSERT_EQ(doubt.path_map.size(), 2U);
  EXPECT_EQ(doubt.path_map[1].x(), 20.0);
}

// Files of older programs do not name the key frames.
TEST_F(SessionMarks, FollowThePathOfASingleDriveByItsStamps) {
  for (KeyFrameIndex i = 0; i < 6; ++i) session_.add_odometry(stamp_of(i), Pose::Identity());
  write_doubtful_section(1.5, 3.5, std::nullopt);
  const DoubtMark doubt = session_marks(session_, poses_).doubts.at(0);
  ASSERT_EQ(doubt.path_map.size(), 4U);
  EXPECT_EQ(doubt.path_map[3].x(), 40.0);
}

// Another vehicle drives 100 m aside at the same time.
TEST_F(SessionMarks, StayInTheDriveOfADoubtfulSection) {
  for (KeyFrameIndex i = 6; i < 12; ++i) {
    KeyFrame key_frame;
    key_frame.index = i;
    key_frame.segment = 2;
    key_frame.stamp = stamp_of(i - 6) + from_seconds(0.5);
    session_.add_key_frame(key_frame);
    Pose pose;
    pose.translation = {10.0 * (i - 6), 100.0, 0.0};
    poses_.poses.push_back({i, key_frame.stamp, pose});
  }
  write_doubtful_section(1.5, 3.5, KeyFrameRange{1, 4});
  const DoubtMark doubt = session_marks(session_, poses_).doubts.at(0);
  EXPECT_EQ(doubt.path_map.size(), 4U);
  for (const Eigen::Vector3d& p_map : doubt.path_map) EXPECT_EQ(p_map.y(), 0.0);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
