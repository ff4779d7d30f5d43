// SPDX-License-Identifier: BSD-3-Clause
// The commands themselves with spoilt files: none of them is ended by a signal or goes on for ever,
// each says what is wrong with what, and no figure is nan. FUZZ_SECONDS (of each kind) and
// FUZZ_SEED of the environment let it run longer and elsewhere.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <regex>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/session/cloud_store.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "example_files.hpp"
#include "file_content.hpp"
#include "fuzz_options.hpp"
#include "limited_run.hpp"
#include "mutation.hpp"
#include "run_record.hpp"
#include "session_damage.hpp"
#include "simulated_drive/drive_output.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;
using rosbag::compression::CompressionType;
using Words = std::vector<std::string>;

struct Kind {
  std::string name;
  std::function<void(const fs::path& folder)> write;
  std::string program;
  Words words;           ///< IN/ stands for the folder of spoilt files, OUT/ for one to write to
  std::string spoilt;    ///< part of the names of the files that are spoilt; all if empty
  int whole_status = 0;  ///< with whole files
  /// Damages a file where that takes more than changed bytes.
  std::function<void(const fs::path& file, std::mt19937& engine)> spoil = {};
};

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

constexpr unsigned kProcessorSeconds = 30;
constexpr std::size_t kLeastCases = 3;

void write_content(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

/// Two seconds of a town with 16 beams, lz4.
void write_drive(const fs::path& folder) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  options.duration = 2.0;
  tools::write_bag(simulation::Drive(options), folder / "drive.bag", {}, 1);
}

class Campaign {
 public:
  Campaign(const Kind& kind, std::uint32_t seed) : kind_(kind), engine_(seed) {
    fs::create_directory(whole_);
    kind_.write(whole_);
    for (const auto& entry : fs::recursive_directory_iterator(whole_)) {
      const fs::path file = fs::relative(entry.path(), whole_);
      const bool is_wanted = file.string().find(kind_.spoilt) != std::string::npos;
      if (entry.is_regular_file() && is_wanted) files_.push_back(file);
    }
    std::sort(files_.begin(), files_.end());
  }

  void run(double seconds) {
    using Clock = std::chrono::steady_clock;
    prepare();
    const RunResult whole = start();
    EXPECT_TRUE(problem_with(whole).empty()) << problem_with(whole);
    EXPECT_EQ(whole.status, kind_.whole_status) << "of whole files\n" << whole.output;
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (Clock::now() < end || cases_ < kLeastCases) spoil_one();
    std::printf("%s: %zu cases, %zu refused\n", kind_.name.c_str(), cases_, refused_);
  }

 private:
  /// The whole files where the command looks for them, and a folder to write to.
  void prepare() const {
    fs::remove_all(in_);
    fs::remove_all(out_);
    fs::create_directory(out_);
    fs::copy(whole_, in_, fs::copy_options::recursive);
  }

  RunResult start() const {
    Words words;
    for (std::string word : kind_.words) {
      if (word.rfind("IN/", 0) == 0) word = (in_ / word.substr(3)).string();
      if (word.rfind("OUT/", 0) == 0) word = (out_ / word.substr(4)).string();
      words.push_back(word);
    }
    return run_limited(fs::path(LIDAR_MAPPING_PROGRAMS) / kind_.program, words,
                       folder_.path() / "said", kProcessorSeconds);
  }

  void spoil_one() {
    ++cases_;
    prepare();
    const fs::path file = files_[engine_() % files_.size()];
    if (kind_.spoil) {
      kind_.spoil(in_ / file, engine_);
    } else {
      write_content(in_ / file, mutated(content_of(whole_ / file), engine_));
    }
    const RunResult result = start();
    refused_ += result.status != kind_.whole_status ? 1 : 0;
    const std::string problem = problem_with(result);
    if (!problem.empty()) keep(problem, result.output);
  }

  static std::string problem_with(const RunResult& result) {
    static const std::regex kNonsense(R"((^|[\s:,=\[(])-?(nan|inf)([\s,\])]|$))");
    if (result.hung) return "it does not end";
    if (result.signal != 0) return "ended by signal " + std::to_string(result.signal);
    for (const char* word : {"Sanitizer", "runtime error:", "terminate called"}) {
      if (result.output.find(word) != std::string::npos) return word;
    }
    if (result.status == 127) return "it did not start";
    if (result.status != 0 && result.output.size() < 10) return "it does not say why it fails";
    const bool is_nonsense = result.status == 0 && std::regex_search(result.output, kNonsense);
    return is_nonsense ? "a figure is nan" : "";
  }

  void keep(const std::string& problem, const std::string& output) const {
    const fs::path kept = fs::temp_directory_path() /
                          ("lidar_mapping_finding_" + kind_.name + "_" + std::to_string(cases_));
    fs::remove_all(kept);
    fs::copy(in_, kept, fs::copy_options::recursive);
    ADD_FAILURE() << kind_.name << ", case " << cases_ << ": " << problem << "; see " << kept
                  << "\n"
                  << output.substr(0, 3000);
  }

  const Kind& kind_;
  std::mt19937 engine_;
  TemporaryFolder folder_;
  fs::path whole_ = folder_.path() / "whole";
  fs::path in_ = folder_.path() / "in";
  fs::path out_ = folder_.path() / "out";
  std::vector<fs::path> files_;
  std::size_t cases_ = 0;
  std::size_t refused_ = 0;
};

std::function<void(const fs::path&)> bag(CompressionType compression) {
  return [compression](const fs::path& folder) { write_bag(folder / "a.bag", compression); };
}

void write_configuration(const fs::path& folder) {
  write_bag(folder / "a.bag", CompressionType::LZ4);
  fs::create_directory(folder / "config");
  write_content(folder / "config" / "back_end.yaml", config::to_yaml(back_end::BackEndConfig()));
  write_content(folder / "sensor.yaml",
                "preprocessing:\n  distance_near_thresh: 1.0\nnodes:\n  queue_size: 5\n");
  write_content(folder / "preset.yaml", "front_end:\n  voxel_size: 0.8\n");
}

void write_trajectories(const fs::path& folder) {
  write_trajectory(folder / "truth.txt", false);
  write_trajectory(folder / "estimate.txt", false);
}

void write_one_session(const fs::path& folder) { write_session(folder / "s"); }

/// With all that a session's folder has beside session.db and is read again.
void write_mapped_session(const fs::path& folder) {
  write_session(folder / "s");
  report::RunRecord record;
  record.command = "map_bag drive.bag -o s";
  record.topics = {{"points", "/points"}};
  report::write_run_record(folder / "s", record);
  fs::create_directory(folder / "s" / "map");
  write_content(folder / "s" / "map" / "map.yaml", "min: [0.0, 0.0, 0.0]\nmax: [1.0, 2.0, 3.0]\n");
}

void write_examined_session(const fs::path& folder) {
  write_session(folder / "s");
  write_localized_drive(folder / "drive", folder / "s");
}

void write_two_sessions(const fs::path& folder) {
  write_session(folder / "a");
  write_session(folder / "b");
}

void write_poses_and_scans(const fs::path& folder) {
  write_kitti_odometry(folder / "scans");
  write_content(folder / "poses.txt",
                "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n");
}

/// A street between two walls, as a map of two tiles.
void write_tiles(const fs::path& folder) {
  fs::create_directory(folder / "map");
  std::string list = "x_resolution: 20.0\ny_resolution: 20.0\n";
  for (const int corner : {0, 20}) {
    PointCloud tile;
    for (int i = 0; i < 100; ++i) {
      const float x = static_cast<float>(corner) + 0.2F * static_cast<float>(i) + 0.1F;
      for (int k = 0; k < 50; ++k) {
        const float step = 0.2F * static_cast<float>(k);
        tile.points.push_back({x, step + 0.1F, 0.0F, 1.0F});
        tile.points.push_back({x, -0.1F, 0.5F * step, 2.0F});
        tile.points.push_back({x, 10.1F, 0.5F * step, 3.0F});
      }
    }
    const std::string name = std::to_string(corner) + "_0.pcd";
    session::write_pcd(folder / "map" / name, tile);
    list += name + ": [" + std::to_string(corner) + ", 0]\n";
  }
  write_content(folder / "map" / "pointcloud_map_metadata.yaml", list);
}

std::vector<Kind> kinds_of_recordings() {
  const Words map_bag = {"IN/a.bag", "-o", "OUT/town", "--formats", "pcd"};
  Words with_config = map_bag, with_overlays = map_bag;
  with_config.insert(with_config.end(), {"--config", "IN/config"});
  with_overlays.insert(with_overlays.end(),
                       {"--sensor", "IN/sensor.yaml", "--preset", "IN/preset.yaml"});
  return {
      {"check_bag_plain", bag(CompressionType::Uncompressed), "check_bag", {"IN/a.bag"}, "", 1},
      {"check_bag_bz2", bag(CompressionType::BZ2), "check_bag", {"IN/a.bag"}, "", 1},
      {"check_bag_lz4", bag(CompressionType::LZ4), "check_bag", {"IN/a.bag"}, "", 1},
      {"check_bag_other_types",
       [](const fs::path& folder) { write_bag_of_other_types(folder / "a.bag"); },
       "check_bag",
       {"IN/a.bag"},
       "",
       1},
      {"check_bag_velodyne",
       [](const fs::path& folder) { write_bag_of_driver(folder / "a.bag", "velodyne"); },
       "check_bag",
       {"IN/a.bag"},
       "",
       1},
      {"check_bag_hesai",
       [](const fs::path& folder) { write_bag_of_driver(folder / "a.bag", "hesai"); },
       "check_bag",
       {"IN/a.bag"},
       "",
       1},
      {"check_bag_ros2",
       [](const fs::path& folder) { write_ros2_recording(folder / "a.db3"); },
       "check_bag",
       {"IN/a.db3"},
       ""},
      {"check_bag_mcap",
       [](const fs::path& folder) { write_mcap_recording(folder / "a.mcap", "zstd"); },
       "check_bag",
       {"IN/a.mcap"},
       ""},
      {"map_bag_plain", bag(CompressionType::Uncompressed), "map_bag", map_bag, "", 1},
      {"map_bag_bz2", bag(CompressionType::BZ2), "map_bag", map_bag, "", 1},
      {"map_bag_drive", write_drive, "map_bag", {"IN/drive.bag", "-o", "OUT/town"}, ""},
      {"map_bag_config", write_configuration, "map_bag", with_config, "config/", 1},
      {"map_bag_overlays", write_configuration, "map_bag", with_overlays, "s", 1},
      {"map_bag_kitti_raw", write_kitti_raw, "map_bag", {"IN/", "-o", "OUT/town"}, ""},
      {"map_bag_kitti_odometry", write_kitti_odometry, "map_bag", {"IN/", "-o", "OUT/town"}, "", 1},
      {"map_bag_scan_folder", write_scan_folder, "map_bag", {"IN/", "-o", "OUT/town"}, ""},
      {"kitti_to_bag_raw", write_kitti_raw, "kitti_to_bag", {"IN/", "OUT/a.bag"}, ""},
      {"kitti_to_bag_poses",
       write_poses_and_scans,
       "kitti_to_bag",
       {"IN/scans", "OUT/a.bag", "--poses-enu", "IN/poses.txt"},
       ""},
      {"odometry_benchmark_kitti",
       write_poses_and_scans,
       "odometry_benchmark",
       {"IN/scans", "--truth", "IN/poses.txt"},
       ""},
      {"odometry_benchmark_bag", bag(CompressionType::LZ4), "odometry_benchmark", {"IN/a.bag"}, ""},
  };
}

std::vector<Kind> kinds_of_results() {
  const Words optimize = {"IN/s", "--output", "OUT/s"};
  const Words build_map = {"IN/s", "-o", "OUT/map"};
  return {
      {"build_map_pcd", write_one_session, "build_map", build_map, ".pcd"},
      {"build_map_db", write_one_session, "build_map", build_map, "session.db"},
      {"build_map_cells", write_one_session, "build_map", build_map, "session.db", 0,
       spoil_session},
      {"optimize_session", write_one_session, "optimize_session", optimize, "session.db"},
      {"optimize_session_cells", write_one_session, "optimize_session", optimize, "session.db", 0,
       spoil_session},
      {"optimize_session_loops",
       [](const fs::path& folder) {
         write_session(folder / "s");
         write_loop_list(folder / "loops.txt");
       },
       "optimize_session",
       {"IN/s", "--loops", "IN/loops.txt", "--output", "OUT/s"},
       "loops.txt",
       1},
      {"merge_sessions",
       write_two_sessions,
       "merge_sessions",
       {"IN/a", "IN/b", "-o", "OUT/s"},
       "",
       1},
      {"merge_sessions_cells",
       write_two_sessions,
       "merge_sessions",
       {"IN/a", "IN/b", "-o", "OUT/s"},
       "session.db",
       1,
       spoil_session},
      {"map_quality", write_mapped_session, "map_quality", {"IN/s"}, ""},
      {"map_quality_cells",
       write_mapped_session,
       "map_quality",
       {"IN/s"},
       "session.db",
       0,
       spoil_session},
      {"map_quality_record", write_mapped_session, "map_quality", {"IN/s"}, "s/run.json"},
      {"map_quality_examined",
       write_examined_session,
       "map_quality",
       {"IN/s", "--examined-by", "IN/drive"},
       "drive/"},
      {"optimize_graph",
       [](const fs::path& folder) { write_g2o(folder / "a.g2o", false); },
       "optimize_graph",
       {"IN/a.g2o", "OUT/b.g2o"},
       ""},
      {"optimize_graph_binary",
       [](const fs::path& folder) { write_binary_graph(folder / "a.lmg", false); },
       "optimize_graph",
       {"IN/a.lmg", "OUT/b.lmg", "--method", "condensed"},
       ""},
      {"evaluate_trajectory",
       write_trajectories,
       "evaluate_trajectory",
       {"IN/truth.txt", "IN/estimate.txt", "--align"},
       ""},
      {"hdl_dump_import",
       [](const fs::path& folder) { write_hdl_dump(folder / "dump"); },
       "hdl_dump",
       {"import", "IN/dump", "-o", "OUT/s"},
       ""},
      {"hdl_dump_export",
       write_one_session,
       "hdl_dump",
       {"export", "IN/s", "-o", "OUT/dump"},
       "session.db",
       0,
       spoil_session},
      {"import_map", write_tiles, "import_map", {"IN/map", "-o", "OUT/s"}, ""},
      {"odometry_campaign",
       [](const fs::path& folder) {
         write_content(folder / "cases.txt", "clean seed=3 scan_rate=10 every=2\n");
       },
       "odometry_campaign",
       {"--cases", "IN/cases.txt", "--lidars", "vlp16", "--duration", "1.0", "--seeds", "1"},
       ""},
  };
}

std::vector<Kind> kinds() {
  std::vector<Kind> all = kinds_of_recordings();
  for (const Kind& kind : kinds_of_results()) all.push_back(kind);
  return all;
}

class FuzzCommands : public testing::TestWithParam<Kind> {};

TEST_P(FuzzCommands, ReportDamagedFiles) {
  const FuzzOptions options = fuzz_options();
  std::printf("seed %u\n", options.seed);
  Campaign(GetParam(), options.seed).run(options.seconds);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCommands, testing::ValuesIn(kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace lidar_mapping::test
