// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/pipeline/map_extension.hpp"

#include "near.hpp"
#include "street_drive.hpp"

namespace lidar_mapping::pipeline::test {
namespace {

using lidar_mapping::test::near;

constexpr double kTolerance = 1e-9;  // m

void expect_nothing(const MapExtension& extension) {
  EXPECT_TRUE(extension.sections.empty());
  EXPECT_NEAR(extension.omitted.never_found, 0.0, kTolerance);
  EXPECT_NEAR(extension.omitted.too_short, 0.0, kTolerance);
  EXPECT_NEAR(extension.omitted.not_tied, 0.0, kTolerance);
}

/// The only section of an extension; one that is not there is a failure.
NewSection only_section(const MapExtension& extension) {
  EXPECT_EQ(extension.sections.size(), 1U);
  return extension.sections.empty() ? NewSection{} : extension.sections.front();
}

void expect_section(const NewSection& section, std::size_t begin, std::size_t end,
                    double new_path_length, const std::vector<std::size_t>& tied) {
  EXPECT_EQ(section.begin, begin);
  EXPECT_EQ(section.end, end);
  EXPECT_NEAR(section.new_path_length, new_path_length, kTolerance);
  std::vector<std::size_t> found;
  for (const Loop& tie : section.ties) found.push_back(tie.to);
  EXPECT_EQ(found, tied);
}

// The drive is in the map for 30 key frames; 15 of them, 31.5 m, belong to the section.
TEST(MapExtension, AddsWhatLiesBehindTheEndOfTheMap) {
  const auto drive = street_drive(times(30, 'f') + times(20, 'b'), 20);
  const MapExtension extension = plan_extension(drive, street_map());
  expect_section(only_section(extension), 15, 50, street_length(20), {15, 18, 21, 24, 27});
  EXPECT_NEAR(extension.omitted.not_tied, 0.0, kTolerance);
}

TEST(MapExtension, TiesToTheNearestKeyFrameOfTheMap) {
  const auto drive = street_drive(times(30, 'f') + times(20, 'b'), 20);
  const NewSection section = only_section(plan_extension(drive, street_map()));
  ASSERT_FALSE(section.ties.empty());
  const Loop& tie = section.ties.front();
  EXPECT_EQ(tie.from, 35U);
  EXPECT_EQ(tie.to, 15U);
  EXPECT_EQ(tie.stamp, drive[15].key_frame.stamp);
  EXPECT_TRUE(near(tie.T_from_to, on_street(0.0, 1.0), kTolerance));
  EXPECT_TRUE(near(tie.covariance, drive[15].place.covariance, kTolerance));
  EXPECT_EQ(tie.decision, LoopDecision::kAuto);
}

// Up to 7 steps, 14.7 m, behind the end of the map its last key frame is near enough.
TEST(MapExtension, AddsWhereTheMapKnowsLittleFarFromItsKeyFrames) {
  const auto drive = street_drive(times(20, 'f') + times(20, 'p'), 30);
  const NewSection section = only_section(plan_extension(drive, street_map()));
  expect_section(section, 13, 40, street_length(12), {13, 16, 19, 22, 25});
  ASSERT_FALSE(section.ties.empty());
  EXPECT_EQ(section.ties.back().from, 50U);
  EXPECT_TRUE(near(section.ties.back().T_from_to, on_street(street_length(5), 1.0), kTolerance));
}

TEST(MapExtension, AddsSurroundingsThatHaveChangedWithTiesOnBothSides) {
  const auto drive = street_drive(times(20, 'f') + times(10, 'b') + times(20, 'f'), 0);
  expect_section(only_section(plan_extension(drive, street_map())), 5, 45, street_length(10),
                 {5, 8, 11, 14, 17, 30, 33, 36, 39, 42});
}

TEST(MapExtension, AddsNothingThatTheMapKnows) {
  for (const std::string& letters :
       {times(40, 'f'), times(10, 's') + times(30, 'f'), times(20, 'f') + times(20, 'p'),
        times(15, 'f') + times(10, 'l') + times(15, 'f'),
        times(15, 'f') + times(10, 'u') + times(15, 'f')}) {
    SCOPED_TRACE(letters);
    expect_nothing(plan_extension(street_drive(letters, 5), street_map()));
  }
  expect_nothing(plan_extension({}, street_map()));
}

// A lorry hides what the map shows.
TEST(MapExtension, LeavesOutWhatIsShort) {
  const auto drive = street_drive(times(20, 'f') + times(4, 'b') + times(20, 'f'), 0);
  const MapExtension extension = plan_extension(drive, street_map());
  EXPECT_TRUE(extension.sections.empty());
  EXPECT_NEAR(extension.omitted.too_short, street_length(4), kTolerance);
}

TEST(MapExtension, TakesShortOnesTogetherThatLieNearEachOther) {
  const auto drive = street_drive(times(20, 'f') + "bbb" + "ff" + "bbb" + times(20, 'f'), 0);
  const NewSection section = only_section(plan_extension(drive, street_map()));
  EXPECT_NEAR(section.new_path_length, street_length(6), kTolerance);
  EXPECT_EQ(section.begin, 5U);
}

TEST(MapExtension, MakesOneSectionOfTwoThatMeet) {
  const auto drive = street_drive(
      times(20, 'f') + times(10, 'b') + times(10, 'f') + times(10, 'b') + times(20, 'f'), 0);
  const NewSection section = only_section(plan_extension(drive, street_map(101)));
  EXPECT_EQ(section.begin, 5U);
  EXPECT_EQ(section.end, 65U);
  EXPECT_NEAR(section.new_path_length, street_length(20), kTolerance);
}

TEST(MapExtension, SeparatesTwoWithALongKnownPathBetweenThem) {
  const auto drive = street_drive(
      times(20, 'f') + times(10, 'b') + times(40, 'f') + times(10, 'b') + times(20, 'f'), 0);
  const MapExtension extension = plan_extension(drive, street_map(101));
  ASSERT_EQ(extension.sections.size(), 2U);
  EXPECT_EQ(extension.sections[0].end, 45U);
  EXPECT_EQ(extension.sections[1].begin, 55U);
}

// The place was given up where nothing of the map was in sight any more; odometry goes on.
TEST(MapExtension, ContinuesWhereThePlaceWasGivenUp) {
  const auto drive = street_drive(times(30, 'f') + times(10, 'b') + times(20, 'l'), 20);
  const NewSection section = only_section(plan_extension(drive, street_map()));
  EXPECT_EQ(section.end, 60U);
  EXPECT_NEAR(section.new_path_length, street_length(30), kTolerance);
}

// The last 7 key frames before the map are nearer to it than 15 m; the first one has no step before
// it.
TEST(MapExtension, AddsWhatLiesBeforeThePlaceWasFound) {
  const auto drive = street_drive(times(30, 's') + times(30, 'f'), -30);
  expect_section(only_section(plan_extension(drive, street_map())), 0, 45, street_length(22),
                 {30, 33, 36, 39, 42});
}

TEST(MapExtension, LeavesOutWhatWasNeverFound) {
  auto drive = street_drive(times(20, 's'), 0);
  const auto later = street_drive(times(30, 'f'), 0, 1, drive.size());
  drive.insert(drive.end(), later.begin(), later.end());
  const MapExtension extension = plan_extension(drive, street_map());
  EXPECT_TRUE(extension.sections.empty());
  EXPECT_NEAR(extension.omitted.never_found, street_length(19), kTolerance);
}

TEST(MapExtension, EndsWhereOdometryDoes) {
  auto drive = street_drive(times(20, 'f') + times(10, 'b'), 30);
  const auto later = street_drive(times(10, 's'), 60, 1, drive.size());
  drive.insert(drive.end(), later.begin(), later.end());
  const MapExtension extension = plan_extension(drive, street_map());
  EXPECT_EQ(only_section(extension).end, 30U);
  EXPECT_NEAR(extension.omitted.never_found, street_length(9), kTolerance);
}

TEST(MapExtension, LeavesOutSectionsWithTooFewTies) {
  const auto drive = street_drive(times(4, 'f') + times(10, 'b'), 46);
  const MapExtension extension = plan_extension(drive, street_map());
  EXPECT_TRUE(extension.sections.empty());
  EXPECT_NEAR(extension.omitted.not_tied, street_length(10), kTolerance);
}

}  // namespace
}  // namespace lidar_mapping::pipeline::test
