// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <gtest/gtest.h>

#include "near.hpp"
#include "pair_search.hpp"
#include "temporary_folder.hpp"
#include "town_session.hpp"

namespace lidar_mapping::city::test {
namespace {

using lidar_mapping::test::TemporaryFolder;
using pipeline::test::along;
using pipeline::test::kStart;
using pipeline::test::make_town;
using pipeline::test::record_drive;
using session::Session;

/// Drive b follows drive a round a block: key frame i of both is at the same place.
class PairSearchTest : public testing::Test {
 protected:
  /// Seven key frames later than drive a: most of their stamps are equal.
  static constexpr Stamp kStartOfB = kStart + from_seconds(1.4);

  void record(const std::string& name, bool with_gnss) {
    const Stamp start = name == "a" ? kStart : kStartOfB;
    Session session = record_drive(path(name), world_, square_, square_, start);
    if (!with_gnss) return;
    session.set_datum({49.0, 8.4, 110.0});
    for (std::size_t i = 0; i < square_.size(); ++i) {
      GnssPosition position;
      position.stamp = start + from_seconds(0.2 * static_cast<double>(i));
      position.p_enu_antenna = square_[i].translation;
      position.covariance = 0.25 * Eigen::Matrix3d::Identity();
      session.add_gnss(position);
    }
  }
  std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }

  PairLoops search(const std::vector<KeyFrameRange>& a_ranges,
                   const std::vector<KeyFrameRange>& b_ranges) const {
    const Chunk chunk{"a--b--000", "a", "b", a_ranges, b_ranges, true, false};
    return search_chunk(Session::open(path("a"), Session::Access::kRead),
                        Session::open(path("b"), Session::Access::kRead), chunk, {}, {},
                        folder_.path());
  }

  const std::vector<Pose> square_ = along({{0, 0}, {60, 0}, {60, 60}, {0, 60}, {0, 0}});
  const pipeline::test::ToyWorld world_ = make_town(110.0, 60.0, 4);
  TemporaryFolder folder_;
};

TEST_F(PairSearchTest, AnEmptyChunkIsNotSearched) {
  record("a", true);
  record("b", true);
  for (const PairLoops& none : {search({}, {{0, 9}}), search({{0, 9}}, {})}) {
    EXPECT_EQ(none.a, "a");
    EXPECT_EQ(none.b, "b");
    EXPECT_FALSE(none.used_gnss);
    EXPECT_EQ(none.searched, 0U);
    EXPECT_TRUE(none.loops.empty());
  }
}

TEST_F(PairSearchTest, SearchesForTheKeyFramesOfTheChunkAlone) {
  record("a", true);
  record("b", true);
  const PairLoops found = search({{0, 119}}, {{30, 49}, {55, 59}});
  EXPECT_TRUE(found.used_gnss);
  EXPECT_EQ(found.searched, 25U);
  ASSERT_FALSE(found.loops.empty());
  ASSERT_GE(found.verdicts.size(), found.loops.size());
  for (const LoopVerdict& verdict : found.verdicts) {
    EXPECT_LT(verdict.from, 120U);
    EXPECT_TRUE((verdict.to >= 30 && verdict.to <= 49) || (verdict.to >= 55 && verdict.to <= 59))
        << verdict.to;
    EXPECT_EQ(verdict.stamp, kStartOfB + from_seconds(0.2 * static_cast<double>(verdict.to)));
  }
  for (const Loop& loop : found.loops) {
    const Pose expected = square_[loop.from].inverse() * square_[loop.to];
    EXPECT_TRUE(lidar_mapping::test::near(loop.T_from_to.translation, expected.translation, 0.3))
        << loop.to;
    EXPECT_EQ(loop.stamp, kStartOfB + from_seconds(0.2 * static_cast<double>(loop.to)));
  }
}

// The last twenty key frames of drive a are at the other side of the block.
TEST_F(PairSearchTest, SearchesInTheKeyFramesOfTheChunkAlone) {
  record("a", true);
  record("b", true);
  const PairLoops found = search({{100, 119}}, {{30, 59}});
  EXPECT_EQ(found.searched, 30U);
  EXPECT_TRUE(found.loops.empty());
}

TEST_F(PairSearchTest, UsesGnssThatBothDrivesHave) {
  record("a", true);
  record("b", false);
  const PairLoops found = search({{0, 9}}, {{0, 0}});
  EXPECT_FALSE(found.used_gnss);
  EXPECT_EQ(found.searched, 1U);
}

}  // namespace
}  // namespace lidar_mapping::city::test
