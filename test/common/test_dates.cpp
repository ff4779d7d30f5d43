// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <ctime>

#include <gtest/gtest.h>

#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {
namespace {

constexpr Stamp kSecond = 1'000'000'000;
constexpr Stamp kMidnight = 1'777'593'600 * kSecond;  // 2026-05-01, date -u -d 2026-05-01 +%s

TEST(Dates, AreWrittenInUtc) {
  EXPECT_EQ(iso_date(kMidnight), "2026-05-01T00:00:00Z");
  EXPECT_EQ(iso_date(kMidnight + 3661 * kSecond + 5), "2026-05-01T01:01:01Z");
}

TEST(Dates, NameFilesByTheLocalTime) {
  const char* const zone = std::getenv("TZ");
  const std::string before = zone == nullptr ? "" : zone;
  setenv("TZ", "XYZ-2", 1);  // two hours east, without a rule for the summer
  tzset();
  EXPECT_EQ(dated_name(kMidnight / kSecond + 3661), "2026-05-01_03-01-01");
  zone == nullptr ? unsetenv("TZ") : setenv("TZ", before.c_str(), 1);
  tzset();
}

TEST(Dates, EndWithTheirLastNanosecond) {
  EXPECT_EQ(end_of_date("2026-05-01"), kMidnight + 86400 * kSecond - 1);
  EXPECT_EQ(end_of_date("2026-05-01T00:00"), kMidnight + 60 * kSecond - 1);
  EXPECT_EQ(end_of_date("2026-05-01T00:00:00Z"), kMidnight + kSecond - 1);
  EXPECT_NO_THROW(end_of_date("2028-02-29"));
}

TEST(Dates, RefuseWhatIsNone) {
  for (const char* text : {"", "yesterday", "2026-13-01", "2026-04-31", "2026-02-29T12:00",
                           "2026-05-01T25:00", "2026-05-01 noon"}) {
    EXPECT_THROW(end_of_date(text), InputError) << text;
  }
}

}  // namespace
}  // namespace lidar_mapping
