// SPDX-License-Identifier: BSD-3-Clause
// Values as they are read into fields and as they are written for people and files.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/load.hpp"

namespace lidar_mapping::config {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Value list(const std::vector<double>& numbers) {
  Value::List elements(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) elements[i].data = numbers[i];
  return {elements};
}

Value word(const std::string& text) { return {text}; }

TEST(ReadValue, TakesNumbersUpToBothEndsOfTheRange) {
  const Range range{1.0, 2.0};
  for (const double number : {1.0, 1.5, 2.0}) {
    double field = 0.0;
    EXPECT_EQ(read_value(Value{number}, range, field), "");
    EXPECT_EQ(field, number);
  }
  for (const double number : {0.999, 2.001, kInfinity, -kInfinity}) {
    double field = 7.0;
    EXPECT_EQ(read_value(Value{number}, range, field), "is out of range");
    EXPECT_EQ(field, 7.0) << "it is left as it is";
  }
}

TEST(ReadValue, TakesWholeNumbersForRealOnesButNotTheReverse) {
  double real = 0.0;
  EXPECT_EQ(read_value(Value{3}, {}, real), "");
  EXPECT_EQ(real, 3.0);
  int whole = 7;
  EXPECT_EQ(read_value(Value{3.0}, {}, whole), "is not an integer");
  EXPECT_EQ(whole, 7);
  EXPECT_EQ(read_value(Value{11}, {1.0, 10.0}, whole), "is out of range");
  EXPECT_EQ(read_value(Value{10}, {1.0, 10.0}, whole), "");
  EXPECT_EQ(whole, 10);
}

TEST(ReadAngle, TakesDegreesWithinTheRangeAndStoresRadians) {
  const Range range{-90.0, 90.0};
  double field = 0.0;
  EXPECT_EQ(read_angle(Value{90}, range, 1.0, field), "");
  EXPECT_DOUBLE_EQ(field, kPi / 2.0);
  EXPECT_EQ(read_angle(Value{-0.2}, range, 1.0, field), "");
  EXPECT_EQ(field, -0.2 * kRadPerDeg);
  EXPECT_EQ(read_angle(Value{90.0}, range, 100.0, field), "");
  EXPECT_DOUBLE_EQ(field, kPi / 200.0) << "a quarter of a turn in 100 m";
  field = 7.0;
  EXPECT_EQ(read_angle(Value{90.001}, range, 1.0, field), "is out of range");
  EXPECT_EQ(read_angle(Value{90.001}, range, 100.0, field), "is out of range");
  EXPECT_EQ(read_angle(word("steep"), range, 1.0, field), "is not a number");
  EXPECT_EQ(field, 7.0) << "it is left as it is";
}

TEST(ReadValue, RefusesWhatIsNoNumber) {
  double field = 7.0;
  EXPECT_EQ(read_value(Value{std::nan("")}, {}, field), "is not a number");
  EXPECT_EQ(read_value(word("far"), {}, field), "is not a number");
  EXPECT_EQ(read_value(Value{true}, {}, field), "is not a number");
  EXPECT_EQ(read_value(Value{}, {}, field), "is not a number");
  EXPECT_EQ(field, 7.0);
}

TEST(ReadValue, TakesNothingForAnEmptyTextOnly) {
  std::string text = "points";
  EXPECT_EQ(read_value(Value{}, text), "");
  EXPECT_EQ(text, "");
  bool flag = true;
  EXPECT_EQ(read_value(Value{}, flag), "is not true or false");
  EXPECT_TRUE(flag);
  EXPECT_EQ(read_value(Value{3}, text), "is not a text");
}

TEST(ReadValue, WantsListsOfTheirLength) {
  std::vector<double> field = {7.0};
  EXPECT_EQ(read_value(list({1.0, 2.5}), 2, field), "");
  EXPECT_EQ(field, (std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(read_value(list({1.0}), 2, field), "has 1 elements");
  EXPECT_EQ(read_value(list({1.0, kInfinity}), 2, field),
            "holds something that is not a finite number");
  EXPECT_EQ(read_value(Value{1.0}, 1, field), "is not a list");
  EXPECT_EQ(field, (std::vector<double>{1.0, 2.5}));
}

TEST(PrintValue, LeavesNumbersReal) {
  EXPECT_EQ(print_value(2.0), "2.0");
  EXPECT_EQ(print_value(-10.0), "-10.0");
  EXPECT_EQ(print_value(0.25), "0.25");
  EXPECT_EQ(print_value(1e-9), "1e-09");
  EXPECT_EQ(print_value(1e15), "1e+15");
  EXPECT_EQ(print_value(-kInfinity), "-.inf");
  EXPECT_EQ(print_value(std::nan("")), ".nan");
  EXPECT_EQ(print_value(3), "3");
  EXPECT_EQ(print_value(std::vector<double>{1.0, -0.5}), "[1.0, -0.5]");
}

TEST(PrintValue, KeepsTwelveDigits) {
  const double number = 1234567.89012;
  const Source source = parse_yaml("a: " + print_value(number) + "\n", "a.yaml");
  double again = 0.0;
  EXPECT_EQ(read_value(flattened(source.values).at("a"), {}, again), "");
  EXPECT_EQ(again, number);
}

// Many of these angles come back from the conversions with another last bit.
TEST(PrintAngle, GivesTheDegreesThatWereRead) {
  int inexact = 0;
  for (int i = -36000; i <= 36000; ++i) {
    const double degrees = i / 100.0;
    for (const double distance : {1.0, 100.0}) {
      double field = 0.0, again = 0.0;
      ASSERT_EQ(read_angle(Value{degrees}, {}, distance, field), "");
      const std::string text = print_angle(field, distance);
      ASSERT_EQ(text, print_value(degrees));
      ASSERT_EQ(read_angle(Value{std::stod(text)}, {}, distance, again), "");
      ASSERT_EQ(again, field);
      inexact += field * distance * kDegPerRad != degrees ? 1 : 0;
    }
  }
  EXPECT_GT(inexact, 1000) << "with all digits these would be printed otherwise";
}

TEST(PrintAngle, GivesTheDegreesOfConstants) {
  EXPECT_EQ(print_angle(0.2 * kRadPerDeg, 1.0), "0.2");
  EXPECT_EQ(print_angle(-kPi, 1.0), "-180.0");
  EXPECT_EQ(print_angle(0.0, 1.0), "0.0");
  EXPECT_EQ(print_angle(1.5 * kRadPerDeg / 100.0, 100.0), "1.5");
}

TEST(DistanceOfAngleUnit, IsThatOfTheUnitsThatThereAre) {
  EXPECT_EQ(distance_of_angle_unit("deg"), 1.0);
  EXPECT_EQ(distance_of_angle_unit("deg/m"), 1.0);
  EXPECT_EQ(distance_of_angle_unit("deg per 100 m"), 100.0);
  for (const char* unit : {"rad", "degrees", "deg/s", ""}) {
    EXPECT_THROW(distance_of_angle_unit(unit), InputError) << unit;
  }
}

TEST(PrintValue, QuotesTexts) {
  EXPECT_EQ(print_value(std::string("a \"b\" \\c")), "\"a \\\"b\\\" \\\\c\"");
  EXPECT_EQ(print_value(std::string()), "\"\"");
}

TEST(Describe, SaysTheLimitsThatThereAre) {
  EXPECT_EQ(describe("integer", {1.0, 256.0}), "integer from 1 to 256");
  EXPECT_EQ(describe("real number", {0.5, kInfinity}), "real number of at least 0.5");
  EXPECT_EQ(describe("real number", {-kInfinity, -0.5}), "real number of at most -0.5");
  EXPECT_EQ(describe("real number", {}), "real number");
}

TEST(DescribeChoices, NamesEachOnce) {
  EXPECT_EQ(describe_choices({"NDT"}), "NDT");
  EXPECT_EQ(describe_choices({"NDT", "ICP"}), "NDT or ICP");
  EXPECT_EQ(describe_choices({"NDT", "ICP", "ndt", "GICP", "Icp"}), "NDT, ICP or GICP");
}

TEST(Flattened, JoinsTheNamesOfGroups) {
  const auto leaves =
      flattened(parse_yaml("a: {b: 1, c: {d: word}}\ne: [1, 2]\nf:\n", "a.yaml").values);
  ASSERT_EQ(leaves.size(), 4U);
  EXPECT_EQ(to_string(leaves.at("a/b")), "1");
  EXPECT_EQ(to_string(leaves.at("a/c/d")), "word");
  EXPECT_EQ(to_string(leaves.at("e")), "[1, 2]");
  EXPECT_EQ(to_string(leaves.at("f")), "nothing");
  EXPECT_TRUE(flattened(Value{3}).empty());
}

TEST(ParseYaml, KnowsTheTypesOfWords) {
  const auto leaves = flattened(
      parse_yaml("a: 'true'\nb: true\nc: \"3\"\nd: 3\ne: 3.0\nf: yes please\n", "a.yaml").values);
  EXPECT_TRUE(std::holds_alternative<std::string>(leaves.at("a").data)) << "in quotation marks";
  EXPECT_TRUE(std::holds_alternative<bool>(leaves.at("b").data));
  EXPECT_TRUE(std::holds_alternative<std::string>(leaves.at("c").data)) << "in quotation marks";
  EXPECT_TRUE(std::holds_alternative<int>(leaves.at("d").data));
  EXPECT_TRUE(std::holds_alternative<double>(leaves.at("e").data));
  EXPECT_TRUE(std::holds_alternative<std::string>(leaves.at("f").data));
}

std::string unknown(const std::string& key, const std::vector<std::string>& names) {
  std::vector<FieldDescription> known;
  for (const std::string& name : names) known.push_back({name, "", "", "", ""});
  return unknown_key_problem(key, Value{1}, known, "a.yaml");
}

// As near as a third of its letters and one more.
TEST(UnknownKeyProblem, SuggestsOnlyWhatIsNear) {
  const std::string begin = "a.yaml: unknown key '";
  EXPECT_EQ(unknown("voxelsize", {"use_imu", "voxel_size", "voxel_sizes"}),
            begin + "voxelsize' (value 1); did you mean 'voxel_size'?");
  EXPECT_EQ(unknown("szie", {"size"}), begin + "szie' (value 1); did you mean 'size'?");
  EXPECT_EQ(unknown("abcdef", {"abcxyz"}), begin + "abcdef' (value 1); did you mean 'abcxyz'?");
  EXPECT_EQ(unknown("abcdef", {"abwxyz"}), begin + "abcdef' (value 1)");
  EXPECT_EQ(unknown("abc", {}), begin + "abc' (value 1)");
}

TEST(YamlDocument, HasAHeadingForEachGroup) {
  const std::vector<FieldDescription> fields = {{"a", "1", "integer", "m", "First."},
                                                {"g/b", "true", "true or false", "", "Second."},
                                                {"g/c", "2", "integer", "s", "Third."}};
  EXPECT_EQ(yaml_document("Head", fields, {"5", "false", "6"}),
            "# Head\n"
            "\n# First.\n# integer, m; default 1\na: 5\n"
            "\ng:\n"
            "\n  # Second.\n  # true or false; default true\n  b: false\n"
            "\n  # Third.\n  # integer, s; default 2\n  c: 6\n");
}

}  // namespace
}  // namespace lidar_mapping::config
