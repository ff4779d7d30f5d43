// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "error_text.hpp"
#include "sensors/fault_text.hpp"

namespace lidar_mapping::simulation {
namespace {

enum class Kind { kNoise, kGap, kWall };

struct Fault {
  Kind kind = Kind::kNoise;
  double amount = 0.0;
};

using Description = FaultDescription<Kind>;

constexpr std::array<Description, 3> kDescriptions = {{{"noise", Kind::kNoise, "noise=0..1", 0, 1},
                                                       {"gap", Kind::kGap, "gap=1..60", 1, 60},
                                                       {"wall", Kind::kWall, "wall", 0, 0}}};

Fault parsed(const std::string& text) {
  const auto read = [](const Description& known, const std::optional<std::string>& value,
                       Fault& fault) {
    if (known.kind == Kind::kWall) return !value;
    return value && matches_format(*value, "%lf%n", &fault.amount) && fault.amount >= known.min &&
           fault.amount <= known.max;
  };
  return parse_fault<Fault>(text, kDescriptions, read);
}

std::string refusal(const std::string& text) {
  return test::error_text<ConfigError>([&] { parsed(text); });
}

TEST(MatchesFormat, ReadsAllNumbersAndNothingElse) {
  double a = 0.0, b = 0.0;
  EXPECT_TRUE(matches_format("3,10.5", "%lf,%lf%n", &a, &b));
  EXPECT_EQ(a, 3.0);
  EXPECT_EQ(b, 10.5);
  for (const char* text : {"", "3", "3,", "3,10.5 ", "3,10.5x", "x3,10.5", "3;10.5"}) {
    EXPECT_FALSE(matches_format(text, "%lf,%lf%n", &a, &b)) << "'" << text << "'";
  }
}

TEST(ParseFault, ReadsKindAndValue) {
  EXPECT_EQ(parsed("noise=0.25").kind, Kind::kNoise);
  EXPECT_EQ(parsed("noise=0.25").amount, 0.25);
  EXPECT_EQ(parsed("gap=60").kind, Kind::kGap);
  EXPECT_EQ(parsed("gap=60").amount, 60.0);
  EXPECT_EQ(parsed("wall").kind, Kind::kWall);
}

TEST(ParseFault, SaysHowAFaultIsWritten) {
  for (const char* text : {"gap", "gap=", "gap=0.5", "gap=61", "gap=2=3", "gap=two"}) {
    EXPECT_EQ(refusal(text), std::string("fault: '") + text + "' is not of the form gap=1..60");
  }
  EXPECT_EQ(refusal("wall=1"), "fault: 'wall=1' is not of the form wall");
}

TEST(ParseFault, NamesAllFaultsIfThereIsNoSuchOne) {
  EXPECT_EQ(refusal("rain=0.1"), "fault: 'rain' is unknown; use one of noise gap wall");
  EXPECT_EQ(refusal("nois=0.1"), "fault: 'nois' is unknown; use one of noise gap wall");
  EXPECT_EQ(refusal(""), "fault: '' is unknown; use one of noise gap wall");
}

TEST(FaultFormats, AreThoseOfTheTable) {
  EXPECT_EQ(fault_formats(kDescriptions),
            (std::vector<std::string>{"noise=0..1", "gap=1..60", "wall"}));
}

}  // namespace
}  // namespace lidar_mapping::simulation
