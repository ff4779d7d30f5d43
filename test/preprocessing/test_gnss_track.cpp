// SPDX-License-Identifier: BSD-3-Clause
// The track of fixes on its own: one fix per second along a parallel, without other sensors. How it
// works together with them is tested in test_gnss_gate.cpp.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"

#include "gnss/gnss_track.hpp"
#include "near.hpp"
#include "samples.hpp"

namespace lidar_mapping::preprocessing {
namespace {

using lidar_mapping::test::near;
using test::at;

constexpr double kLatitude = 49.0;  // degrees
constexpr double kLongitude = 8.4;
constexpr double kAltitude = 115.0;            // m
constexpr double kSpeed = 10.0;                // m/s, to the east
constexpr Stamp kLatency = from_seconds(0.2);  // s for which a sample may be late

/// Metres for each degree of longitude: the radius of the parallel on the ellipsoid of WGS 84.
double metres_per_degree() {
  constexpr double kMajorAxis = 6378137.0;       // m
  constexpr double kEccentricity2 = 0.00669438;  // squared
  const double latitude = kLatitude * kPi / 180.0;
  const double prime_vertical =
      kMajorAxis / std::sqrt(1.0 - kEccentricity2 * std::pow(std::sin(latitude), 2));
  return (prime_vertical + kAltitude) * std::cos(latitude) * kPi / 180.0;
}

/// What a receiver says `seconds` after the beginning, if it is that far to the east (m).
GnssFix fix_at(double seconds, double east) {
  return test::fix(at(seconds), kLatitude, kLongitude + east / metres_per_degree(), kAltitude);
}
GnssFix fix_at(double seconds) { return fix_at(seconds, kSpeed * seconds); }

/// The default configuration after `change`.
template <typename Change>
PreprocessingConfig changed(const Change& change) {
  PreprocessingConfig config;
  change(config);
  return config;
}

class Track : public testing::Test {
 protected:
  explicit Track(const PreprocessingConfig& config = {})
      : sensors_(config, extrinsics_), track_(config, extrinsics_) {}

  Insertion add(const GnssFix& fix) { return track_.add(fix, "gps").insertion; }
  /// Nothing else will arrive.
  std::vector<std::string> evaluate_all() {
    return track_.evaluate_pending(sensors_, {at(1e4), kLatency}, Waiting::kEnds);
  }
  /// Adds fixes from `first` to `last` seconds and evaluates them.
  void drive(int first, int last) {
    for (int i = first; i <= last; ++i) {
      ASSERT_EQ(add(fix_at(i)), Insertion::kInserted) << i;
    }
    EXPECT_TRUE(evaluate_all().empty());
  }
  Eigen::Vector3d position_at(double seconds) const {
    const auto position = track_.at(at(seconds));
    return position ? position->p_enu_antenna
                    : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  std::string messages() { return test::messages_of(track_); }

  Pose T_base_antenna_{Eigen::Quaterniond::Identity(), {0.3, -0.2, 1.5}};
  Extrinsics extrinsics_{[this](const std::string& frame) -> std::optional<Pose> {
    if (frame != "gps") return std::nullopt;
    return T_base_antenna_;
  }};
  MotionSensors sensors_;
  GnssTrack track_;
};

TEST_F(Track, BeginsAtTheFirstFixAndInterpolates) {
  drive(0, 3);
  EXPECT_TRUE(near(position_at(0.0), Eigen::Vector3d(0.0, 0.0, 0.0), 1e-6));
  EXPECT_TRUE(near(position_at(1.0), Eigen::Vector3d(10.0, 0.0, 0.0), 1e-3));
  EXPECT_TRUE(near(position_at(2.25), Eigen::Vector3d(22.5, 0.0, 0.0), 1e-3));
  const auto position = track_.at(at(1.5));
  ASSERT_TRUE(position);
  EXPECT_EQ(position->stamp, at(1.5));
  EXPECT_TRUE(near(position->p_base_antenna, T_base_antenna_.translation, 1e-12));
  EXPECT_FALSE(position->R_enu_base) << "fixes have no heading";
}

TEST_F(Track, HasNoPositionBesideTheFixesAndInGaps) {
  drive(0, 2);
  EXPECT_FALSE(track_.at(at(-0.01)));
  EXPECT_FALSE(track_.at(at(2.01)));
  ASSERT_EQ(add(fix_at(4)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_TRUE(track_.at(at(4.0)));
  EXPECT_FALSE(track_.at(at(3.0))) << "2 s are more than gnss_max_gap";
}

TEST_F(Track, HasNoPositionWithoutTheAntennasTransform) {
  for (int i = 0; i < 3; ++i) track_.add(fix_at(i), "unknown");
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_FALSE(track_.at(at(1.5)));
}

TEST_F(Track, SortsFixesThatWait) {
  for (const int i : {0, 2, 1, 3}) EXPECT_EQ(add(fix_at(i)), Insertion::kInserted) << i;
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_TRUE(near(position_at(1.5), Eigen::Vector3d(15.0, 0.0, 0.0), 1e-3));
}

TEST_F(Track, RefusesFixesThatRepeatATimeOrComeTooLate) {
  EXPECT_EQ(add(fix_at(1)), Insertion::kInserted);
  EXPECT_EQ(add(fix_at(1)), Insertion::kRefused) << "one like it waits";
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_EQ(add(fix_at(1)), Insertion::kRefused) << "one like it was evaluated";
  EXPECT_EQ(add(fix_at(0)), Insertion::kRefused);
  EXPECT_NE(track_.add(fix_at(0), "gps").problem.find("repeats the time"), std::string::npos);
  EXPECT_EQ(add(fix_at(2)), Insertion::kInserted);
}

TEST_F(Track, ReportsThatTimeWentBackByMoreThanTwoSeconds) {
  drive(0, 5);
  EXPECT_EQ(add(fix_at(3.1)), Insertion::kRefused);
  EXPECT_EQ(add(fix_at(2.9)), Insertion::kTimeWentBack);
  ASSERT_EQ(add(fix_at(10)), Insertion::kInserted);
  EXPECT_EQ(add(fix_at(7.9)), Insertion::kTimeWentBack) << "also if a fix waits";
}

TEST_F(Track, RefusesUnusableFixesWithTheReason) {
  GnssFix none = fix_at(0);
  none.status = -1;
  const FixResult result = track_.add(none, "gps");
  EXPECT_EQ(result.insertion, Insertion::kRefused);
  EXPECT_EQ(result.problem, "the receiver has no fix");
  EXPECT_TRUE(evaluate_all().empty()) << "it is not evaluated";
}

// IMU and velocity are switched on, and may still begin.
TEST_F(Track, WaitsForTheMotionForTheTimeOfALateSample) {
  EXPECT_EQ(add(fix_at(1)), Insertion::kInserted);
  EXPECT_EQ(add(fix_at(2)), Insertion::kInserted);
  EXPECT_TRUE(track_.may_still_deliver(at(2.0), {at(2.1), kLatency}));
  EXPECT_FALSE(track_.may_still_deliver(at(2.0), {at(2.3), kLatency}));
  track_.evaluate_pending(sensors_, {at(2.1), kLatency}, Waiting::kGoesOn);
  EXPECT_FALSE(track_.at(at(1.5))) << "the second one waits";
  track_.evaluate_pending(sensors_, {at(2.3), kLatency}, Waiting::kGoesOn);
  EXPECT_TRUE(track_.at(at(1.5)));
}

TEST_F(Track, KeepsTheLastTwoHundredFixesThatWait) {
  for (int i = 0; i < 250; ++i) EXPECT_EQ(add(fix_at(0.05 * i)), Insertion::kInserted);
  const std::vector<std::string> dropped = evaluate_all();
  ASSERT_EQ(dropped.size(), 50U) << "the others are counted as refused";
  EXPECT_NE(dropped[0].find("before 200 later fixes came"), std::string::npos) << dropped[0];
  EXPECT_TRUE(evaluate_all().empty()) << "they are told once";
  EXPECT_EQ(track_.stream().buffer().oldest().stamp, at(0.05 * 50));
  EXPECT_EQ(track_.stream().buffer().newest().stamp, at(0.05 * 249));
}

TEST_F(Track, HasNoDatumUntilTwoFixesAgree) {
  EXPECT_EQ(add(fix_at(0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_FALSE(track_.datum());
  EXPECT_EQ(add(fix_at(1)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  ASSERT_TRUE(track_.datum());
  EXPECT_EQ(*track_.datum(), (GeodeticDatum{kLatitude, kLongitude, kAltitude}));
}

// 70 m/s are the fastest that a car drives.
TEST_F(Track, RejectsAJumpAndGoesOnBehindIt) {
  drive(0, 2);
  ASSERT_EQ(add(fix_at(3.0, 20.0 + 75.0)), Insertion::kInserted);
  const std::vector<std::string> rejected = evaluate_all();
  ASSERT_EQ(rejected.size(), 1U);
  EXPECT_NE(rejected[0].find("a jump: 75.0 m since the last fix"), std::string::npos)
      << rejected[0];
  ASSERT_EQ(add(fix_at(4.0, 40.0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_TRUE(near(position_at(4.0), Eigen::Vector3d(40.0, 0.0, 0.0), 1e-3));
}

TEST_F(Track, BeginsAgainIfTheNextTwoAgreeAgainstTheFirst) {
  const double away = 5000.0;
  ASSERT_EQ(add(fix_at(0.0, 0.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(1.0, away)), Insertion::kInserted);
  EXPECT_EQ(evaluate_all().size(), 1U) << "nothing says which one is right";
  EXPECT_FALSE(track_.datum());
  ASSERT_EQ(add(fix_at(2.0, away + 10.0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_TRUE(near(position_at(1.0), Eigen::Vector3d::Zero(), 1e-6)) << "the frame begins there";
  EXPECT_TRUE(near(position_at(2.0), Eigen::Vector3d(10.0, 0.0, 0.0), 1e-3));
  ASSERT_TRUE(track_.datum());
  EXPECT_NEAR(track_.datum()->longitude_deg, kLongitude + away / metres_per_degree(), 1e-12);
  const std::string text = messages();
  EXPECT_NE(text.find("the first fix is 5 km from the next ones"), std::string::npos) << text;
}

TEST_F(Track, DoesNotBeginAgainForLessThanAKilometre) {
  ASSERT_EQ(add(fix_at(0.0, 0.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(1.0, 980.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(2.0, 985.0)), Insertion::kInserted);
  EXPECT_EQ(evaluate_all().size(), 2U);
  EXPECT_EQ(messages(), "");
}

TEST_F(Track, DoesNotBeginAgainIfTheNextTwoContradictEachOther) {
  ASSERT_EQ(add(fix_at(0.0, 0.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(1.0, 5000.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(2.0, 5100.0)), Insertion::kInserted);  // 20 m and 70 m/s are allowed
  EXPECT_EQ(evaluate_all().size(), 2U);
}

TEST_F(Track, DoesNotBeginAgainOnceTwoFixesAgreed) {
  drive(0, 1);
  ASSERT_EQ(add(fix_at(2.0, 5000.0)), Insertion::kInserted);
  ASSERT_EQ(add(fix_at(3.0, 5010.0)), Insertion::kInserted);
  EXPECT_EQ(evaluate_all().size(), 2U);
  EXPECT_EQ(track_.datum()->longitude_deg, kLongitude);
}

TEST_F(Track, UsesFixesWithoutAltitudeInThePlane) {
  for (int i = 0; i < 3; ++i) {
    GnssFix fix = fix_at(i);
    if (i > 0) fix.altitude_m = std::numeric_limits<double>::quiet_NaN();
    ASSERT_EQ(add(fix), Insertion::kInserted);
  }
  EXPECT_TRUE(evaluate_all().empty());
  const auto position = track_.at(at(1.5));
  ASSERT_TRUE(position);
  EXPECT_TRUE(near(position->p_enu_antenna, Eigen::Vector3d(15.0, 0.0, 0.0), 1e-3));
  EXPECT_FALSE(has_height(position->covariance));
  EXPECT_NE(messages().find("at the height of the datum, 115.00 m"), std::string::npos);
}

TEST_F(Track, DiscardsFixesButNotItsFrame) {
  drive(0, 3);
  ASSERT_EQ(add(fix_at(4)), Insertion::kInserted);
  track_.clear();
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_FALSE(track_.at(at(1.5)));
  EXPECT_TRUE(track_.stream().buffer().empty());
  ASSERT_TRUE(track_.datum());
  EXPECT_EQ(add(fix_at(-100.0, 500.0)), Insertion::kInserted) << "another time, another place";
  EXPECT_EQ(add(fix_at(-99.0, 510.0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_NEAR(position_at(-99.5).x(), 505.0, 0.01);
}

class TrackWithoutGating : public Track {
 protected:
  TrackWithoutGating() : Track(changed([](auto& config) { config.gnss_gating = false; })) {}
};

TEST_F(TrackWithoutGating, AcceptsJumpsAndIsSureOfItsDatum) {
  ASSERT_EQ(add(fix_at(0.0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_TRUE(track_.datum());
  ASSERT_EQ(add(fix_at(1.0, 5000.0)), Insertion::kInserted);
  EXPECT_TRUE(evaluate_all().empty());
  EXPECT_NEAR(position_at(1.0).x(), 5000.0, 0.01);
}

class TrackWithOffset : public Track {
 protected:
  TrackWithOffset() : Track(changed([](auto& config) { config.gnss_time_offset = -0.5; })) {}
};

TEST_F(TrackWithOffset, MovesTheStampsByTheConfiguredOffset) {
  drive(0, 3);
  EXPECT_NEAR(position_at(1.5).x(), 20.0, 1e-3) << "the fix of 2 s was measured at 1.5 s";
}

class TrackWithDatum : public Track {
 protected:
  TrackWithDatum()
      : Track(changed([](auto& config) {
          config.use_datum = true;
          config.datum = {kLatitude, kLongitude - 200.0 / metres_per_degree(), kAltitude};
        })) {}
};

TEST_F(TrackWithDatum, IsInTheConfiguredFrameFromTheBeginning) {
  EXPECT_TRUE(track_.datum());
  drive(0, 1);
  EXPECT_NEAR(position_at(1.0).x(), 210.0, 0.01);
}

/// Whether the heading of an IMU may be used, as the configuration says.
bool accepts_heading(ImuOrientation orientation) {
  PreprocessingConfig config;
  config.imu_orientation = orientation;
  const Extrinsics extrinsics(test::identity_lookup);
  GnssTrack track(config, extrinsics);
  return track.accepts_heading({}, Eigen::Quaterniond::Identity(), false);
}

TEST(Heading, IsAcceptedAsConfiguredOrOnceTheTrackConfirmsIt) {
  EXPECT_TRUE(accepts_heading(ImuOrientation::kEnu));
  EXPECT_FALSE(accepts_heading(ImuOrientation::kNone));
  EXPECT_FALSE(accepts_heading(ImuOrientation::kAuto)) << "nothing confirms it yet";
  PreprocessingConfig config;
  config.imu_orientation = ImuOrientation::kAuto;
  const Extrinsics extrinsics(test::identity_lookup);
  // Driven east with a heading of east, and with one of north.
  for (const bool right : {true, false}) {
    GnssTrack track(config, extrinsics);
    const Eigen::Quaterniond R = exp_so3({0.0, 0.0, right ? 0.0 : kPi / 2.0});
    bool accepted = false;
    for (int i = 0; i < 100; ++i) {
      GnssPosition position;
      position.p_enu_antenna.x() = i;
      position.covariance = 0.0004 * Eigen::Matrix3d::Identity();
      accepted = track.accepts_heading(position, R, false);
    }
    EXPECT_EQ(accepted, right);
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
