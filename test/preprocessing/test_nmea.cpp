// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <gtest/gtest.h>

#include "lidar_mapping/preprocessing/nmea.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr Stamp kStamp = 1317384506123456789;

/// The example of the standard's descriptions, with an altitude of 545.4 m above a geoid that is
/// 46.9 m above the ellipsoid.
const std::string kGga = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47";

TEST(Nmea, ReadsTheFixOfAGgaSentence) {
  const auto fix = fix_of_nmea(kGga + "\r\n", kStamp);
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->stamp, kStamp);
  EXPECT_NEAR(fix->latitude_deg, 48.0 + 7.038 / 60.0, 1e-12);
  EXPECT_NEAR(fix->longitude_deg, 11.0 + 31.0 / 60.0, 1e-12);
  EXPECT_NEAR(fix->altitude_m, 592.3, 1e-9);
  EXPECT_EQ(fix->status, 0);
  ASSERT_TRUE(fix->covariance);
  EXPECT_NEAR(std::sqrt((*fix->covariance)(0, 0)), 3.6, 1e-9);
  EXPECT_NEAR(std::sqrt((*fix->covariance)(2, 2)), 7.2, 1e-9);
}

TEST(Nmea, ReadsAllConstellationsHemispheresAndQualities) {
  const auto fix =
      fix_of_nmea("$GNGGA,123519.25,3351.5,S,15112.5,W,4,20,0.5,10.0,M,-3.0,M,1.0,0001", kStamp);
  ASSERT_TRUE(fix) << "a sentence without a checksum is taken";
  EXPECT_NEAR(fix->latitude_deg, -(33.0 + 51.5 / 60.0), 1e-12);
  EXPECT_NEAR(fix->longitude_deg, -(151.0 + 12.5 / 60.0), 1e-12);
  EXPECT_NEAR(fix->altitude_m, 7.0, 1e-12);
  EXPECT_EQ(fix->status, 2) << "RTK";
  EXPECT_LT(std::sqrt((*fix->covariance)(0, 0)), 0.02);
  const auto vague = fix_of_nmea("$GPGGA,1,4807.0,N,01131.0,E,2,08,,545.4,M,,M,,", kStamp);
  ASSERT_TRUE(vague);
  EXPECT_EQ(vague->status, 1);
  EXPECT_EQ(vague->altitude_m, 545.4);
  EXPECT_FALSE(vague->covariance) << "without a dilution nobody knows";
}

TEST(Nmea, APositionInThePlaneHasNoAltitude) {
  const auto fix = fix_of_nmea("$GPGGA,123519,4807.038,N,01131.000,E,1,04,0.9,,M,46.9,M,,", kStamp);
  ASSERT_TRUE(fix);
  EXPECT_NEAR(fix->latitude_deg, 48.0 + 7.038 / 60.0, 1e-12);
  EXPECT_TRUE(std::isnan(fix->altitude_m));
}

TEST(SentenceCheck, SaysOnceThatAReceiverSendsNoGga) {
  const std::string rmc = "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A";
  const auto warnings = [&](const std::string& other) {
    SentenceCheck check;
    std::size_t count = 0;
    for (int i = 0; i < 300; ++i) {
      if (!check.add(rmc).empty()) ++count;
      if (!check.add(other).empty()) ++count;
    }
    return count;
  };
  EXPECT_EQ(warnings(rmc), 1U);
  EXPECT_EQ(warnings("$GPGSA,A,3"), 1U);
  EXPECT_EQ(warnings("$"), 1U);
  EXPECT_EQ(warnings(kGga), 0U);
  EXPECT_EQ(warnings("$GNGGA,123519,,,,,0,00,99.99,,,,,,*56"), 0U) << "it has no position yet";
}

TEST(Nmea, RejectsSentencesWithoutFixAndDamagedOnes) {
  for (const std::string& sentence :
       {std::string(), std::string("$"), std::string("$GPGGA"), std::string(30, ','),
        std::string("$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A"),
        std::string("$GPGGA,123519,,,,,0,00,99.99,,,,,,*48"),  // no fix
        std::string("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*48"),
        std::string("$GPGGA,123519,4807.038,N,01131.000,E,0,08,0.9,545.4,M,46.9,M,,"),
        std::string("$GPGGA,123519,4867.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        std::string("$GPGGA,123519,9107.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        std::string("$GPGGA,123519,nan,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        std::string("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,5x.4,M,46.9,M,,"),
        std::string("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,1e308,M,1e308,M,,"),
        kGga.substr(0, 30)}) {
    EXPECT_FALSE(fix_of_nmea(sentence, kStamp)) << sentence;
  }
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
