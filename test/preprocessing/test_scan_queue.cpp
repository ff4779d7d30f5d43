// SPDX-License-Identifier: BSD-3-Clause
// Which scans wait, in which order they are released, and which stamps are believed.

#include <gtest/gtest.h>

#include "samples.hpp"
#include "scan_queue.hpp"
#include "stamp_guard.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using test::at;

WaitingScan scan_at(double seconds) {
  WaitingScan scan;
  scan.raw.stamp = at(seconds);
  return scan;
}

TEST(ScanQueue, ReleasesScansInTheOrderOfTheirStamps) {
  ScanQueue queue;
  for (const double seconds : {0.2, 0.0, 0.3, 0.1}) {
    EXPECT_EQ(queue.insert(scan_at(seconds)), Insertion::kInserted) << seconds;
  }
  for (const double seconds : {0.0, 0.1, 0.2, 0.3}) {
    EXPECT_EQ(queue.oldest().raw.stamp, at(seconds));
    EXPECT_EQ(queue.take_oldest().raw.stamp, at(seconds));
  }
  EXPECT_TRUE(queue.empty());
}

TEST(ScanQueue, RefusesAStampThatWaitsAlready) {
  ScanQueue queue;
  queue.insert(scan_at(0.0));
  queue.insert(scan_at(0.1));
  EXPECT_EQ(queue.insert(scan_at(0.0)), Insertion::kRefused);
  EXPECT_EQ(queue.insert(scan_at(0.1)), Insertion::kRefused);
  EXPECT_EQ(queue.size(), 2U);
}

TEST(ScanQueue, RefusesWhatIsNotAfterTheLastOneReleased) {
  ScanQueue queue;
  queue.insert(scan_at(0.1));
  queue.insert(scan_at(0.2));
  queue.take_oldest();
  EXPECT_EQ(queue.insert(scan_at(0.05)), Insertion::kRefused);
  EXPECT_EQ(queue.insert(scan_at(0.1)), Insertion::kRefused);
  EXPECT_EQ(queue.insert(scan_at(0.15)), Insertion::kInserted) << "late, but in time";
  EXPECT_EQ(queue.oldest().raw.stamp, at(0.15));
}

TEST(ScanQueue, SaysThatTimeWentBackByMoreThanTwoSeconds) {
  ScanQueue queue;
  queue.insert(scan_at(10.0));
  EXPECT_EQ(queue.insert(scan_at(7.9)), Insertion::kTimeWentBack) << "beside one that waits";
  EXPECT_EQ(queue.insert(scan_at(8.0)), Insertion::kInserted);
  EXPECT_EQ(queue.size(), 2U);
  queue.take_oldest();
  queue.take_oldest();
  EXPECT_EQ(queue.insert(scan_at(7.9)), Insertion::kTimeWentBack) << "beside one that is gone";
  EXPECT_EQ(queue.insert(scan_at(9.0)), Insertion::kRefused);
}

TEST(ScanQueue, BeginsAnewAfterItWasCleared) {
  ScanQueue queue;
  queue.insert(scan_at(10.0));
  queue.insert(scan_at(10.1));
  queue.take_oldest();
  queue.clear();
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.insert(scan_at(0.0)), Insertion::kInserted);
}

TEST(ScanQueue, IsTooLongWithMoreThanThirtyScans) {
  ScanQueue queue;
  for (int i = 0; i < 30; ++i) queue.insert(scan_at(0.1 * i));
  EXPECT_FALSE(queue.is_too_long());
  queue.insert(scan_at(3.0));
  EXPECT_TRUE(queue.is_too_long());
  queue.take_oldest();
  EXPECT_FALSE(queue.is_too_long());
}

TEST(StampGuard, AcceptsAnyFirstStamp) {
  StampGuard guard;
  EXPECT_EQ(guard.newest(), 0);
  EXPECT_TRUE(guard.accepts(at(5.0), at(900.0)));
  EXPECT_EQ(guard.newest(), at(5.0));
}

TEST(StampGuard, AcceptsStampsThatAreALittleLate) {
  StampGuard guard;
  guard.accepts(at(10.0), at(10.0));
  EXPECT_TRUE(guard.accepts(at(8.0), at(10.0)));
  EXPECT_EQ(guard.newest(), at(10.0)) << "time does not go back with them";
  EXPECT_TRUE(guard.accepts(at(20.0), at(10.0))) << "a pause of ten seconds";
  EXPECT_EQ(guard.newest(), at(20.0));
}

TEST(StampGuard, RefusesASingleStrayStamp) {
  StampGuard guard;
  guard.accepts(at(10.0), at(10.0));
  for (const double stray : {20.5, 7.5, 1000.0}) {
    EXPECT_FALSE(guard.accepts(at(stray), at(10.0))) << stray;
    EXPECT_TRUE(guard.accepts(at(10.0), at(10.0))) << stray;
    EXPECT_EQ(guard.newest(), at(10.0)) << stray;
  }
}

// Two stray stamps agree with each other, but a good one came between them.
TEST(StampGuard, DiscardsAStrayStampWithTheNextGoodOne) {
  StampGuard guard;
  guard.accepts(at(10.0), at(10.0));
  EXPECT_FALSE(guard.accepts(at(100.0), at(10.0)));
  EXPECT_TRUE(guard.accepts(at(10.1), at(10.1)));
  EXPECT_FALSE(guard.accepts(at(100.1), at(10.1)));
}

TEST(StampGuard, AcceptsAJumpThatTheNextStampConfirms) {
  for (const double jump : {500.0, -500.0}) {
    StampGuard guard;
    guard.accepts(at(1000.0), at(1000.0));
    EXPECT_FALSE(guard.accepts(at(1000.0 + jump), at(1000.0))) << jump;
    EXPECT_FALSE(guard.accepts(at(1000.0 - jump), at(1000.0))) << "which confirms nothing";
    EXPECT_FALSE(guard.accepts(at(1000.0 + jump), at(1000.0))) << jump;
    EXPECT_TRUE(guard.accepts(at(1000.1 + jump), at(1000.0))) << jump;
    EXPECT_EQ(guard.newest(), at(1000.1 + jump)) << jump;
  }
}

TEST(StampGuard, FollowsTheOtherInputsForwardsOnly) {
  StampGuard guard;
  guard.accepts(at(10.0), at(10.0));
  EXPECT_TRUE(guard.accepts(at(60.0), at(60.5))) << "after a pause of its own";
  EXPECT_EQ(guard.newest(), at(60.0));
  EXPECT_FALSE(guard.accepts(at(10.0), at(10.0))) << "time of the others went back";
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
