// Spoilt files of every kind through the functions that read them, in this process: nothing but
// this package's own errors comes back, nothing hangs, and what is taken is made of finite numbers.
// FUZZ_SECONDS (of each kind) and FUZZ_SEED of the environment let it run longer and elsewhere.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/back_end/g2o_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/session/loop_files.hpp"
#include "lidar_mapping/session/session.hpp"

#include "bag_input.hpp"
#include "campaign_case.hpp"
#include "example_files.hpp"
#include "fuzz_options.hpp"
#include "mutation.hpp"
#include "pcd_scan.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;
using rosbag::compression::CompressionType;

struct Kind {
  std::string name;
  std::function<void(const fs::path& folder)> write;
  std::function<void(const fs::path& folder)> read;
};

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_content(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

/// Spoils one file of the folder after the other.
class Campaign {
 public:
  Campaign(const Kind& kind, std::uint32_t seed) : kind_(kind), engine_(seed) {
    fs::create_directory(whole_);
    kind_.write(whole_);
    for (const auto& entry : fs::recursive_directory_iterator(whole_)) {
      if (entry.is_regular_file()) files_.push_back(fs::relative(entry.path(), whole_));
    }
    std::sort(files_.begin(), files_.end());
  }

  void run(double seconds) {
    std::printf("%s: spoilt files in %s\n", kind_.name.c_str(), folder_.path().c_str());
    std::fflush(stdout);
    fs::copy(whole_, folder_.path() / "as_written", fs::copy_options::recursive);
    kind_.read(folder_.path() / "as_written");
    const double end = processor_seconds() + seconds;
    while (processor_seconds() < end || cases_ < kLeastCases) spoil_one();
    std::printf("%s: %zu cases, %zu refused\n", kind_.name.c_str(), cases_, refused_);
  }

 private:
  static constexpr std::size_t kLeastCases = 60;
  static constexpr double kLongest = 20.0;  // s of processor time for one case

  void spoil_one() {
    ++cases_;
    const fs::path spoilt = folder_.path() / "spoilt";
    fs::remove_all(spoilt);
    fs::copy(whole_, spoilt, fs::copy_options::recursive);
    const fs::path file = files_[engine_() % files_.size()];
    write_content(spoilt / file, mutated(content_of(whole_ / file), engine_));
    const double begin = processor_seconds();
    try {
      kind_.read(spoilt);
    } catch (const Error& error) {
      ++refused_;
      EXPECT_GT(std::string(error.what()).size(), 10U);
    } catch (const std::exception& error) {
      keep(spoilt, std::string("not an error of this package: ") + error.what());
    }
    if (processor_seconds() - begin > kLongest) keep(spoilt, "it takes too long");
  }

  void keep(const fs::path& spoilt, const std::string& problem) const {
    const fs::path kept = fs::temp_directory_path() /
                          ("lidar_mapping_finding_" + kind_.name + "_" + std::to_string(cases_));
    fs::remove_all(kept);
    fs::copy(spoilt, kept, fs::copy_options::recursive);
    ADD_FAILURE() << kind_.name << ", case " << cases_ << ": " << problem << "; see " << kept;
  }

  const Kind& kind_;
  std::mt19937 engine_;
  TemporaryFolder folder_;
  fs::path whole_ = folder_.path() / "whole";
  std::vector<fs::path> files_;
  std::size_t cases_ = 0;
  std::size_t refused_ = 0;
};

/// What is taken is to be of finite numbers.
void require(bool is_sound, const char* what) {
  if (!is_sound) throw std::runtime_error(std::string("nonsense was taken: ") + what);
}

void read_all(pipeline::InputSource& source) {
  while (auto input = source.next()) {
    if (auto* scan = std::get_if<pipeline::RecordedScan>(&*input)) {
      try {
        preprocessing::RawScan raw = scan->decode({});
        raw.unpack();
      } catch (const InputError&) {
        continue;  // the stage drops it
      }
    }
  }
  source.take_notices();
}

Kind bag(const std::string& name, CompressionType compression) {
  return {name, [compression](const fs::path& folder) { write_bag(folder / "a.bag", compression); },
          [](const fs::path& folder) {
            tools::BagInput input({folder / "a.bag"}, {}, "base_link", {});
            input.examine(0.0);
            read_all(input);
          }};
}

void read_session(const fs::path& folder) {
  const auto session = session::Session::open(folder, session::Session::Access::kRead);
  for (const KeyFrame& key_frame : session.key_frames()) {
    require(is_finite(key_frame.T_odom_base), "a pose");
    session.clouds().cloud(key_frame.index);
  }
  for (const Loop& loop : session.loops()) require(is_finite(loop.T_from_to), "a loop");
  for (const auto& pose : session.poses().poses) require(is_finite(pose.T_map_base), "a pose");
  for (const auto& [stamp, pose] : session.odometry()) require(is_finite(pose), "odometry");
  for (const auto& fix : session.gnss()) require(fix.p_enu_antenna.allFinite(), "a fix");
  session.verdicts();
  session.imu();
  session.floors();
  session.scans();
  session.revisions();
  session.run_id();
  session.datum();
  session.sensor_origin();
  session.configurations();
}

Kind pcd(const std::string& data, bool times) {
  return {"pcd_" + data + (times ? "_times" : ""),
          [=](const fs::path& folder) { write_pcd(folder / "a.pcd", data, times); },
          [](const fs::path& folder) {
            session::read_pcd(folder / "a.pcd");
            try {
              tools::read_pcd_scan(folder / "a.pcd", 0, {});
            } catch (const InputError&) {
            }
          }};
}

Kind g2o(bool planar) {
  return {planar ? "g2o_planar" : "g2o",
          [=](const fs::path& folder) { write_g2o(folder / "a.g2o", planar); },
          [](const fs::path& folder) {
            const auto file = back_end::read_g2o(folder / "a.g2o");
            for (const auto& node : file.graph.nodes) require(is_finite(node.pose), "a vertex");
          }};
}

Kind trajectory(bool kitti) {
  return {kitti ? "trajectory_kitti" : "trajectory_tum",
          [=](const fs::path& folder) { write_trajectory(folder / "a.txt", kitti); },
          [](const fs::path& folder) {
            for (const auto& entry : read_trajectory(folder / "a.txt").poses) {
              require(is_finite(entry.pose), "a pose");
              require(entry.pose.translation.norm() < 1e10, "a place beyond the Moon");
            }
          }};
}

void read_folder(const fs::path& folder) {
  pipeline::FolderInput input(folder);
  read_all(input);
}

std::vector<Kind> kinds() {
  return {
      bag("bag_plain", CompressionType::Uncompressed),
      bag("bag_bz2", CompressionType::BZ2),
      bag("bag_lz4", CompressionType::LZ4),
      {"session", [](const fs::path& folder) { write_session(folder / "s"); },
       [](const fs::path& folder) { read_session(folder / "s"); }},
      pcd("ascii", false),
      pcd("binary", false),
      pcd("binary_compressed", false),
      pcd("binary", true),
      {"yaml",
       [](const fs::path& folder) {
         write_content(folder / "back_end.yaml", config::to_yaml(back_end::BackEndConfig()));
       },
       [](const fs::path& folder) {
         config::load_file<back_end::BackEndConfig>(folder / "back_end.yaml");
       }},
      g2o(false),
      g2o(true),
      trajectory(false),
      trajectory(true),
      {"loop_list", [](const fs::path& folder) { write_loop_list(folder / "loops.txt"); },
       [](const fs::path& folder) {
         for (const auto& edit : session::read_loop_list(folder / "loops.txt")) {
           require(!edit.guess || is_finite(*edit.guess), "a guess");
         }
       }},
      {"hdl_dump", [](const fs::path& folder) { write_hdl_dump(folder / "dump"); },
       [](const fs::path& folder) {
         auto session = session::Session::create_in(folder / "session");
         pipeline::read_hdl_dump(folder / "dump", session);
         for (const auto& pose : session.poses().poses) require(is_finite(pose.T_map_base), "pose");
       }},
      {"kitti_raw", write_kitti_raw, read_folder},
      {"kitti_odometry", write_kitti_odometry, read_folder},
      {"campaign_cases",
       [](const fs::path& folder) {
         std::string lines;
         for (const auto& example : tools::usual_cases()) lines += tools::to_line(example) + "\n";
         write_content(folder / "cases.txt", lines);
       },
       [](const fs::path& folder) { tools::read_cases(folder / "cases.txt"); }},
  };
}

class FuzzReaders : public testing::TestWithParam<Kind> {};

TEST_P(FuzzReaders, OutliveSpoiltFiles) {
  const FuzzOptions options = fuzz_options();
  std::printf("seed %u\n", options.seed);
  Campaign(GetParam(), options.seed).run(options.seconds);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzReaders, testing::ValuesIn(kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace lidar_mapping::test
