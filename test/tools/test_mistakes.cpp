// SPDX-License-Identifier: BSD-3-Clause
// What the commands say to what cannot work: never an abort, always what is wrong and with what.
#include "commands.hpp"

namespace lidar_mapping::tools {
namespace {

using test::holds;
using test::Words;

struct Mistake {
  std::string program;
  Words words;         ///< FOLDER stands for an empty folder, FILE for a file with a word in it
  std::string answer;  ///< a part of it
};

class Mistakes : public test::Commands, public testing::WithParamInterface<Mistake> {
 protected:
  std::string filled_in(const std::string& word) const {
    if (word == "FOLDER") return folder_.path() / "empty";
    return word == "FILE" ? std::string(folder_.path() / "file") : word;
  }

  void SetUp() override {
    std::filesystem::create_directory(folder_.path() / "empty");
    std::ofstream(folder_.path() / "file") << "word\n";
    std::ofstream(folder_.path() / "overlay.yaml") << "frontend: {max_speed: 3}\n";
  }
};

TEST_P(Mistakes, AreAnswered) {
  Words words;
  for (const std::string& word : GetParam().words) words.push_back(filled_in(word));
  const int status = run(GetParam().program, words).status;
  EXPECT_GE(status, 1);
  EXPECT_LT(status, 128);  // 128 and more: ended by a signal
  EXPECT_TRUE(has_said(GetParam().answer));
}

const Mistake kMistakes[] = {
    {"check_bag", {"FOLDER"}, "it is a folder"},
    {"check_bag", {"FILE"}, "it is no bag"},
    {"check_bag", {"FILE", "--config", "FOLDER"}, "there is no <stage>.yaml in"},
    {"check_bag", {"FILE", "--sensor", "vlp61"}, "no sensor vlp61 in"},
    {"check_bag", {"FILE", "--config", "missing"}, "no folder or file missing"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--config", "FOLDER"}, "there is no <stage>.yaml in"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--config", "FILE"}, "there is no <stage>.yaml in"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--config", "missing"}, "no folder or file missing"},
    {"map_bag",
     {"FILE", "-o", "FOLDER", "--parameter", "frontend/threads: 2"},
     "no stage has the name 'frontend'; the stages are back_end"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--parameter", "threads: 2"}, "'stage/name: value'"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--parameter", "front_end/thread: 2"}, "thread"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--duration", "0"}, "0 is not a number above 0"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--threads", "-1"}, "-1 is not 0 or a number above"},
    {"map_bag", {"FILE", "-o", "FOLDER", "--resolution", "0"}, "allowed: real number from 0.01"},
    {"localize_bag", {"FILE", "FOLDER", "-o", "FOLDER"}, "is no bag"},
    {"localize_bag", {"FILE", "-o", "new"}, "drive_and_map"},
    {"localize_bag",
     {"FILE", "FOLDER", "-o", "FOLDER", "--initial-pose", "1", "2"},
     "--initial-pose"},
    {"localize_bag", {"FILE", "FOLDER", "-o", "FILE"}, "exists and is no empty folder"},
    {"localize_bag",
     {"FILE", "FOLDER", "-o", "new", "--extend", "FILE"},
     "exists and is no empty folder"},
    {"localize_bag",
     {"FILE", "FOLDER", "-o", "new/results", "--extend", "new"},
     "would lie in the new session"},
    {"import_map", {"FOLDER", "-o", "new"}, "nor a PCD file in"},
    {"import_map", {"missing.pcd", "-o", "new"}, "there is no map missing.pcd"},
    {"import_map", {"FILE", "-o", "new"}, "it is no PCD file"},
    {"import_map", {"FILE", "-o", "FILE"}, "exists and is no empty folder"},
    {"import_map", {"FILE", "-o", "new", "--spacing", "9"}, "--spacing"},
    {"import_map", {"FILE", "-o", "new", "--trajectory", "missing.tum"}, "missing.tum"},
    {"simulate_drive", {"new.bag", "--drive", "tunnel", "--reverse"}, "has no meaning"},
    {"build_map", {"FOLDER", "--pixel", "0"}, "0 is not a number above 0"},
    {"build_map", {"FOLDER"}, "there is no session in"},
    {"merge_sessions", {"FOLDER", "FOLDER", "-o", "new"}, "is given twice"},
    {"merge_sessions", {"FOLDER", "FILE", "-o", "new", "--config", "FOLDER"}, "no back_end.yaml"},
    {"optimize_session", {"FOLDER", "--config", "FOLDER"}, "there is no session in"},
    {"odometry_benchmark", {"FOLDER", "--config", "FOLDER"}, "there is no front_end.yaml in"},
    {"optimize_graph", {"FOLDER", "FILE"}, "optimize_graph: cannot read"},
    {"optimize_graph", {"missing.g2o", "FILE"}, "missing.g2o: No such file or directory"},
    {"evaluate_trajectory", {"FOLDER", "FOLDER"}, "it is a folder"},
    {"evaluate_trajectory", {"FILE", "FILE", "--lengths", "0"}, "0 is not a number above 0"},
    {"evaluate_trajectory", {"FILE", "FILE", "--delta", "-4"}, "-4 is not 0 or a number above"},
    {"evaluate_trajectory", {"FILE", "FILE", "--align", "--align-origin"}, "exclude each other"},
    {"evaluate_trajectory", {"FILE", "FILE", "--n-to-align", "5"}, "has no meaning without"},
    {"evaluate_trajectory", {"FILE", "FILE", "--n-to-align", "2"}, "2 is not 3 or more"},
    {"simulate_drive", {"FILE"}, "exists; name another file, or give --force"},
    {"simulate_drive", {"--truth", "FILE"}, "exists; name another file, or give --force"},
    {"kitti_to_bag", {"FOLDER", "FILE"}, "exists; name another file, or give --force"},
    {"simulate_drive", {"FOLDER", "--range-noise", "-1"}, "-1 is not 0 or a number above"},
    {"simulate_drive",
     {"new.bag", "--rounds", "4"},
     "--rounds has no meaning for the drive 'town'"},
    {"kitti_to_bag", {"FOLDER", "new.bag"}, "name the folder above it"},
};
INSTANTIATE_TEST_SUITE_P(Commands, Mistakes, testing::ValuesIn(kMistakes));

TEST_F(Mistakes, LeaveFilesAsTheyWere) {
  EXPECT_EQ(run("simulate_drive", {filled_in("FILE"), "--duration", "2"}), 1);
  EXPECT_EQ(test::content_of(filled_in("FILE")), "word\n");
}

TEST_F(Mistakes, InADumpLeaveNoFolder) {
  for (const char* graph : {"", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"}) {
    std::ofstream(folder_.path() / "empty" / "graph.g2o") << graph;
    EXPECT_EQ(
        run("hdl_dump", {"import", filled_in("FOLDER"), "-o", folder_.path() / "new session"}), 1);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      EXPECT_FALSE(holds(entry.path().filename().string(), "new session")) << entry.path();
    }
  }
}

TEST_F(Mistakes, LeaveNoScanToTheBenchmark) {
  const std::filesystem::path scans = folder_.path() / "empty/velodyne";
  std::filesystem::create_directory(scans);
  std::ofstream(scans / "000000.bin") << std::string(16, '\0');
  EXPECT_EQ(run("odometry_benchmark",
                {filled_in("FOLDER"), "--first", "1", "--truth", filled_in("FILE")}),
            1);
  EXPECT_TRUE(has_said("--first 1 leaves none of the 1 scans"));
}

TEST_F(Mistakes, InAnOverlayAreNoticed) {
  EXPECT_EQ(run("map_bag", {filled_in("FILE"), "-o", filled_in("FOLDER"), "--sensor",
                            folder_.path() / "overlay.yaml"}),
            1);
  EXPECT_TRUE(has_said("no stage has the name 'frontend'"));
}

}  // namespace
}  // namespace lidar_mapping::tools
