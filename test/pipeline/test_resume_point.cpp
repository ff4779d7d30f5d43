// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"

#include "near.hpp"
#include "resume_point.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using front_end::FrontEndResult;
using test::near;

constexpr double kSpacing = 10.0;  // m from key frame to key frame

Stamp stamp_of(std::size_t i) {
  return from_seconds(100.0) + from_seconds(1.0) * static_cast<Stamp>(i);
}

/// Where the vehicle is at key frame i in the frame of the run that ended.
Pose pose_of(std::size_t i) {
  return {exp_so3({0.0, 0.0, 0.1 * static_cast<double>(i)}),
          {kSpacing * static_cast<double>(i), 0.0, 0.0}};
}

KeyFrame key_frame(std::size_t i) {
  KeyFrame key_frame;
  key_frame.index = static_cast<KeyFrameIndex>(i);
  key_frame.segment = 3;
  key_frame.stamp = stamp_of(i);
  key_frame.T_odom_base = pose_of(i);
  return key_frame;
}

class ResumePointOf : public testing::Test {
 protected:
  void add(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      KeyFrame added = key_frame(i);
      added.cloud = std::make_shared<PointCloud>();
      session_.add_key_frame(added);
    }
  }

  test::TemporaryFolder folder_;
  session::Session session_ = session::Session::create_in(folder_.path() / "session");
};

TEST_F(ResumePointOf, ASessionWithoutKeyFramesIsNone) {
  EXPECT_FALSE(resume_point_of(session_, 50.0, false));
  EXPECT_FALSE(resume_point_of(session_, 50.0, true));
}

TEST_F(ResumePointOf, ASectionIsAtLeastAsLongAsWanted) {
  add(8);
  const auto point = resume_point_of(session_, 25.0, false);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->first.index, 4U) << "30 m";
  EXPECT_EQ(point->last.index, 7U);
  EXPECT_FALSE(point->from_beginning());
}

TEST_F(ResumePointOf, AShortSessionIsRepeatedWhole) {
  add(3);
  EXPECT_TRUE(resume_point_of(session_, 25.0, false)->from_beginning());
  EXPECT_FALSE(resume_point_of(session_, 5.0, false)->from_beginning());
  EXPECT_TRUE(resume_point_of(session_, 5.0, true)->from_beginning()) << "as was asked for";
}

/// The front end began anew at key frame 4, with a frame and numbers of its own.
class Resumed : public testing::Test {
 protected:
  static constexpr std::size_t kFirst = 4, kLast = 7;

  /// What the front end gives for the place of key frame i.
  FrontEndResult result(std::size_t i, bool is_key_frame = true) const {
    FrontEndResult result;
    result.stamp = stamp_of(i);
    result.T_odom_base = T_new_old_ * pose_of(i);
    if (is_key_frame) {
      result.key_frame = key_frame(i - kFirst);
      result.key_frame->segment = 0;
      result.key_frame->stamp = result.stamp;
      result.key_frame->T_odom_base = result.T_odom_base;
    }
    return result;
  }
  void repeat_section() {
    for (std::size_t i = kFirst; i <= kLast; ++i) {
      FrontEndResult repeated = result(i);
      EXPECT_FALSE(odometry_.accepts(repeated)) << i;
    }
  }

  const Pose T_new_old_ = pose_of(kFirst).inverse();
  ResumedOdometry odometry_{{key_frame(kFirst), key_frame(kLast)}};
};

TEST_F(Resumed, NeedsTheSectionAlone) {
  EXPECT_FALSE(odometry_.needs(stamp_of(kFirst) - 1));
  EXPECT_TRUE(odometry_.needs(stamp_of(kFirst)));
  const ResumedOdometry whole({key_frame(0), key_frame(kLast)});
  EXPECT_TRUE(whole.needs(stamp_of(0) - 1)) << "scans before the first key frame belong to it";
}

TEST_F(Resumed, GoesOnWhereTheSessionEnds) {
  repeat_section();
  FrontEndResult next = result(kLast + 1);
  ASSERT_TRUE(odometry_.accepts(next));
  EXPECT_TRUE(near(next.T_odom_base, pose_of(kLast + 1), 1e-9));
  ASSERT_TRUE(next.key_frame);
  EXPECT_EQ(next.key_frame->index, kLast + 1);
  EXPECT_EQ(next.key_frame->segment, 3U);
  EXPECT_TRUE(near(next.key_frame->T_odom_base, pose_of(kLast + 1), 1e-9));
  FrontEndResult other = result(kLast + 2, false);
  EXPECT_TRUE(odometry_.accepts(other));
  EXPECT_FALSE(other.key_frame);
  EXPECT_TRUE(near(other.T_odom_base, pose_of(kLast + 2), 1e-9));
}

TEST_F(Resumed, CountsNewSegmentsOn) {
  repeat_section();
  FrontEndResult lost = result(kLast + 1);
  lost.key_frame->segment = 1;
  ASSERT_TRUE(odometry_.accepts(lost));
  EXPECT_EQ(lost.key_frame->segment, 4U);
}

TEST_F(Resumed, RefusesAnotherRecording) {
  FrontEndResult late = result(kFirst);
  late.stamp += 1;
  EXPECT_THROW(odometry_.accepts(late), InputError);
  ResumedOdometry other({key_frame(kFirst), key_frame(kLast)});
  FrontEndResult first = result(kFirst);
  other.accepts(first);
  FrontEndResult beyond = result(kLast);
  beyond.stamp += 1;
  EXPECT_THROW(other.accepts(beyond), InputError) << "it has no scan at the last key frame";
}

/// 0.2 m and half a degree at the end of the section.
TEST_F(Resumed, RefusesAnotherEndOfTheSection) {
  const auto end_with = [&](const Pose& error) {
    ResumedOdometry odometry({key_frame(kFirst), key_frame(kLast)});
    FrontEndResult first = result(kFirst), last = result(kLast);
    odometry.accepts(first);
    last.T_odom_base = last.T_odom_base * error;
    odometry.accepts(last);
  };
  EXPECT_NO_THROW(end_with({exp_so3({0.0, 0.0, 0.008}), {0.19, 0.0, 0.0}}));
  EXPECT_THROW(end_with({Eigen::Quaterniond::Identity(), {0.0, 0.21, 0.0}}), ResumeFailure);
  EXPECT_THROW(end_with({exp_so3({0.0, 0.01, 0.0}), {0.0, 0.0, 0.0}}), ResumeFailure);
}

TEST_F(Resumed, RefusesASectionWithoutKeyFrames) {
  FrontEndResult first = result(kFirst, false), last = result(kLast, false);
  odometry_.accepts(first);
  EXPECT_THROW(odometry_.accepts(last), ResumeFailure);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
