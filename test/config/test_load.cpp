// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/config/load.hpp"

#include "error_text.hpp"
#include "holds.hpp"

namespace lidar_mapping::config {
namespace {

using test::holds;

enum class Method { kNdt, kIcp };

struct Part {
  double size = 0.5;
  static const Schema<Part>& schema() {
    static const auto schema = Schema<Part>("part", "A part")
                                   .real("size", &Part::size, {0.1, 2.0}, "m", "Edge of a voxel.")
                                   .alias("leaf", "size");
    return schema;
  }
};

struct Sample {
  double distance = 2.0;
  int count = 20;
  bool enabled = true;
  std::string topic = "points";
  std::vector<double> box = {0.0, 1.0};
  Method method = Method::kNdt;
  Part part;
  static const Schema<Sample>& schema() {
    static const auto schema =
        Schema<Sample>("sample", "A sample")
            .real("key_frame_distance", &Sample::distance, {0.1, 100.0}, "m", "Distance.")
            .integer("local_frame_num", &Sample::count, {1, 1000}, "key frames", "Window.")
            .boolean("use_gnss", &Sample::enabled, "Switch.")
            .text("topic", &Sample::topic, "Topic.")
            .reals("box", &Sample::box, 2, "m", "Box.")
            .choice("method", &Sample::method, {{"NDT", Method::kNdt}, {"ICP", Method::kIcp}},
                    "Method.")
            .include(&Sample::part, Part::schema(), "filter/")
            .alias("window", "local_frame_num")
            .check([](const Sample& s) {
              return s.box[0] < s.box[1] ? "" : std::string("box must grow; swap its numbers");
            });
    return schema;
  }
};

Sample load_text(const std::string& text) { return load<Sample>({parse_yaml(text, "a.yaml")}); }

std::string problem_of(const std::string& text) {
  return test::error_text<ConfigError>([&] { load_text(text); });
}

TEST(Load, KeepsDefaultsForMissingKeys) {
  const Sample sample = load_text("local_frame_num: 7\n");
  EXPECT_EQ(sample.count, 7);
  EXPECT_EQ(sample.distance, 2.0);
}

TEST(Load, ReadsEveryType) {
  const Sample sample = load_text(
      "key_frame_distance: 3\nlocal_frame_num: 5\nuse_gnss: false\ntopic: scan\nbox: [1, 2.5]\n"
      "method: ICP\nfilter: {size: 0.25}\n");
  EXPECT_EQ(sample.distance, 3.0);
  EXPECT_EQ(sample.count, 5);
  EXPECT_FALSE(sample.enabled);
  EXPECT_EQ(sample.topic, "scan");
  EXPECT_EQ(sample.box, (std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(sample.method, Method::kIcp);
  EXPECT_EQ(sample.part.size, 0.25);
}

TEST(Load, LaterSourcesWin) {
  const auto sample = load<Sample>({parse_yaml("local_frame_num: 5\ntopic: a\n", "base.yaml"),
                                    parse_yaml("local_frame_num: 6\n", "sensor.yaml")});
  EXPECT_EQ(sample.count, 6);
  EXPECT_EQ(sample.topic, "a");
}

TEST(Load, NamesKeyValueRangeAndFile) {
  EXPECT_EQ(problem_of("key_frame_distance: -1\n"),
            "a.yaml: key_frame_distance: -1 is out of range; allowed: real number from 0.1 to 100 "
            "(m)");
}

TEST(Load, SuggestsTheNearestKey) {
  EXPECT_EQ(problem_of("key_frame_distence: 1\n"),
            "a.yaml: unknown key 'key_frame_distence' (value 1); did you mean "
            "'key_frame_distance'?");
}

TEST(Load, ReportsAllProblemsALineEach) {
  const std::string problem =
      problem_of("local_frame_num: 1.5\nmethod: FOO\nbox: [2, 1]\nxyz: 1\n");
  EXPECT_EQ(std::count(problem.begin(), problem.end(), '\n'), 3);
  EXPECT_TRUE(holds(problem, "local_frame_num: 1.5 is not an integer"));
  EXPECT_TRUE(holds(problem, "method: FOO is none of the choices; allowed: NDT or ICP"));
  EXPECT_TRUE(holds(problem, "box must grow"));
  EXPECT_TRUE(holds(problem, "unknown key 'xyz'"));
}

TEST(Load, KnowsOtherNamesOfAField) {
  const Sample sample = load_text("window: 9\nfilter: {leaf: 0.75}\n");
  EXPECT_EQ(sample.count, 9);
  EXPECT_EQ(sample.part.size, 0.75);
  EXPECT_FALSE(holds(to_yaml(sample), "window"));
}

/// As lidar_localization gives the edges of a voxel.
TEST(Load, ReadsThreeEqualNumbersAsOne) {
  EXPECT_EQ(load_text("filter: {leaf: [0.6, 0.6, 0.6]}\n").part.size, 0.6);
  EXPECT_TRUE(holds(problem_of("filter: {size: [0.6, 0.6, 0.7]}\n"), "three different numbers"));
  EXPECT_TRUE(holds(problem_of("filter: {size: [3.0, 3.0, 3.0]}\n"), "out of range"));
  EXPECT_TRUE(holds(problem_of("filter: {size: [0.6]}\n"), "not a number"));
  EXPECT_TRUE(holds(problem_of("filter: {size: [a, b, c]}\n"), "not a finite number"));
}

TEST(Load, RefusesAFieldUnderTwoNamesInOneSource) {
  EXPECT_EQ(problem_of("local_frame_num: 5\nwindow: 9\n"),
            "a.yaml: 'local_frame_num' and 'window' are names of the same parameter; remove one of "
            "them");
}

TEST(Load, RefusesWrongTypes) {
  EXPECT_NE(problem_of("use_gnss: 1\n"), "");
  EXPECT_NE(problem_of("topic: 3\n"), "");
  EXPECT_NE(problem_of("key_frame_distance: far\n"), "");
  EXPECT_NE(problem_of("key_frame_distance: .nan\n"), "");
  EXPECT_NE(problem_of("box: [1]\n"), "");
}

TEST(Print, YamlComesBackTheSame) {
  Sample sample;
  sample.distance = 12.0;
  sample.method = Method::kIcp;
  sample.part.size = 0.3;
  const Sample again = load_text(to_yaml(sample));
  EXPECT_EQ(again.distance, 12.0);
  EXPECT_EQ(again.method, Method::kIcp);
  EXPECT_EQ(again.part.size, 0.3);
}

TEST(Print, TextComesBackTheSameWhateverItHolds) {
  Sample sample;
  for (const std::string text : {"", "/points", "C:\\files", "a \"quoted\" word", "# 'x': [1]"}) {
    sample.topic = text;
    EXPECT_EQ(load_text(to_yaml(sample)).topic, text);
  }
}

struct Angles {
  double tilt = 0.2 * kRadPerDeg;
  double drift = 0.3 * kRadPerDeg;
  double slow_drift = 1.1 * kRadPerDeg / 100.0;
  static const Schema<Angles>& schema() {
    static const auto schema =
        Schema<Angles>("angles", "Angles")
            .angle("tilt_deg", &Angles::tilt, {-90.0, 90.0}, "deg", "Tilt.")
            .angle("drift_deg_per_m", &Angles::drift, {0.0, 10.0}, "deg/m", "Drift.")
            .angle("drift_deg", &Angles::slow_drift, {0.0, 90.0}, "deg per 100 m", "Drift.");
    return schema;
  }
};

Angles load_angles(const std::string& text) { return load<Angles>({parse_yaml(text, "a.yaml")}); }

void expect_same(const Angles& a, const Angles& b) {
  EXPECT_EQ(a.tilt, b.tilt);
  EXPECT_EQ(a.drift, b.drift);
  EXPECT_EQ(a.slow_drift, b.slow_drift);
}

TEST(Angles, AreDegreesInFilesAndRadiansInTheStruct) {
  const Angles angles = load_angles("tilt_deg: -20\ndrift_deg_per_m: 2.5\ndrift_deg: 10.0\n");
  EXPECT_EQ(angles.tilt, -20.0 * kRadPerDeg);
  EXPECT_EQ(angles.drift, 2.5 * kRadPerDeg);
  EXPECT_DOUBLE_EQ(angles.slow_drift, 0.1 * kRadPerDeg) << "rad/m";
}

TEST(Angles, ComeBackTheSameAndAsTheyWereWritten) {
  const Angles angles = load_angles("tilt_deg: 12.3\ndrift_deg_per_m: 0.07\ndrift_deg: 0.7\n");
  const std::string text = to_yaml(angles);
  for (const char* line :
       {"\ntilt_deg: 12.3\n", "\ndrift_deg_per_m: 0.07\n", "\ndrift_deg: 0.7\n"}) {
    EXPECT_TRUE(holds(text, line));
  }
  expect_same(load_angles(text), angles);
}

TEST(Angles, HaveTheirDefaultsInDegreesInDocumentsAndExactlyInFiles) {
  EXPECT_EQ(to_yaml(Angles()),
            "# Angles\n"
            "\n# Tilt.\n# real number from -90 to 90, deg; default 0.2\ntilt_deg: 0.2\n"
            "\n# Drift.\n# real number from 0 to 10, deg/m; default 0.3\ndrift_deg_per_m: 0.3\n"
            "\n# Drift.\n# real number from 0 to 90, deg per 100 m; default 1.1\ndrift_deg: 1.1\n");
  EXPECT_TRUE(holds(to_markdown<Angles>(),
                    "| `drift_deg` | `1.1` | real number from 0 to 90 | deg per "
                    "100 m | Drift. |\n"));
  expect_same(load_angles(to_yaml(Angles())), Angles());
}

TEST(Angles, AreRefusedAsTheyWereWritten) {
  const std::string problem = test::error_text<ConfigError>(
      [] { load_angles("drift_deg: 90.5\ndrift_deg_per_m: fast\ntilt_deg: -91\n"); });
  EXPECT_EQ(problem,
            "a.yaml: drift_deg: 90.5 is out of range; allowed: real number from 0 to 90 (deg per "
            "100 m)\n"
            "a.yaml: drift_deg_per_m: fast is not a number; allowed: real number from 0 to 10 "
            "(deg/m)\n"
            "a.yaml: tilt_deg: -91 is out of range; allowed: real number from -90 to 90 (deg)");
}

TEST(Print, TableHasALinePerField) {
  const std::string table = to_markdown<Sample>();
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2 + 7);
}

TEST(ReadYamlFile, SaysWhichFileIsMissing) {
  EXPECT_THROW(read_yaml_file("/nonexistent.yaml"), FileError);
}

// What ends the parser, or would go on for ever; all of it has been seen in damaged files.
TEST(Load, RefusesDamagedFilesWithFileAndLine) {
  const auto repeated = [](const std::string& part, int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += part;
    return text;
  };
  std::string laughs = "a0: &a0 [1, 1]\n";
  for (int i = 1; i < 28; ++i) {
    const std::string before = std::to_string(i - 1), now = std::to_string(i);
    laughs += "a" + now + ": &a" + now + " [*a" + before + ", *a" + before + "]\n";
  }
  const std::pair<std::string, std::string> bad[] = {
      {"b: 1\na: &ring [*ring]\n", "a.yaml:2: "},
      {"b: 1\na: " + repeated("[", 20'000) + "\n", "a.yaml:2: "},
      {"b: 1\na: " + repeated("{a: ", 20'000) + "\n", "a.yaml:2: "},
      {"b: 1\n" + repeated("- ", 20'000) + "\n", "a.yaml:2: "},
      {"b: 1\n" + repeated("? ", 20'000) + "\n", "a.yaml:2: "},
      {"b: 1\n[1, 2]: 3\n", "a.yaml:2: "},
      {"b: 1\na: {c: ]\n", "a.yaml:2: "},
      {"b: 1\n\tc: 2\n", "a.yaml:"},
      {"b: 1\na: *none\n", "a.yaml:2: "},
      {std::string("b: 1\na: \0 1\n", 13), "a.yaml:2: "},
      {laughs, "a.yaml:"}};
  for (const auto& [text, place] : bad) {
    const std::string problem =
        test::error_text<ConfigError>([&text = text] { parse_yaml(text, "a.yaml"); });
    EXPECT_EQ(problem.rfind(place, 0), 0U) << problem << " for " << text.substr(0, 60);
  }
}

}  // namespace
}  // namespace lidar_mapping::config
