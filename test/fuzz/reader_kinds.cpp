// SPDX-License-Identifier: BSD-3-Clause
#include "reader_kinds.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <variant>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"
#include "lidar_mapping/pose_graph/g2o_file.hpp"
#include "lidar_mapping/pose_graph/graph_file.hpp"
#include "lidar_mapping/preprocessing/nmea.hpp"
#include "lidar_mapping/session/loop_files.hpp"
#include "lidar_mapping/session/session.hpp"

#include "bag_input.hpp"
#include "campaign_case.hpp"
#include "examined_drive.hpp"
#include "example_files.hpp"
#include "map_input.hpp"
#include "parameters/stage_files.hpp"
#include "pcd_scan.hpp"
#include "run_record.hpp"
#include "session_damage.hpp"

namespace lidar_mapping::test {

namespace {

namespace fs = std::filesystem;
using rosbag::compression::CompressionType;
using Kind = ReaderKind;

void write_content(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

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
        require(raw.cloud.times.empty() || raw.cloud.times.size() == raw.cloud.size(), "times");
      } catch (const InputError&) {
        continue;  // the stage drops it
      }
    }
  }
  source.take_messages();
}

void read_bag(const fs::path& path) {
  const auto input = recordings::make_bag_input({path}, {}, "base_link", {});
  input->examine(0.0);
  read_all(*input);
}

Kind bag(const std::string& name, CompressionType compression) {
  return {name, [compression](const fs::path& folder) { write_bag(folder / "a.bag", compression); },
          [](const fs::path& folder) { read_bag(folder / "a.bag"); }};
}

Kind bag_of(const std::string& driver) {
  return {"bag_" + driver,
          [driver](const fs::path& folder) { write_bag_of_driver(folder / "a.bag", driver); },
          [](const fs::path& folder) { read_bag(folder / "a.bag"); }};
}

/// Packets with the calibration of their sensor.
Kind velodyne_calibration() {
  return {"velodyne_calibration",
          [](const fs::path& folder) {
            write_velodyne_calibration(folder / "lasers.yaml");
            write_bag_of_driver(folder / "a.bag", "velodyne");
          },
          [](const fs::path& folder) {
            preprocessing::PreprocessingConfig config;
            config.velodyne_calibration = folder / "lasers.yaml";
            read_all(*recordings::make_bag_input({folder / "a.bag"}, {}, "base_link", config));
          },
          {},
          "lasers.yaml"};
}

Kind hesai_calibration() {
  return {"hesai_calibration",
          [](const fs::path& folder) {
            write_hesai_calibration(folder / "lasers.csv");
            write_bag_of_driver(folder / "a.bag", "hesai");
          },
          [](const fs::path& folder) {
            preprocessing::PreprocessingConfig config;
            config.hesai_calibration = folder / "lasers.csv";
            read_all(*recordings::make_bag_input({folder / "a.bag"}, {}, "base_link", config));
          },
          {},
          "lasers.csv"};
}

Kind ros2() {
  return {"ros2", [](const fs::path& folder) { write_ros2_recording(folder / "a.db3"); },
          [](const fs::path& folder) { read_bag(folder / "a.db3"); }};
}

Kind mcap(const std::string& compression) {
  const auto write = [compression](const fs::path& folder) {
    write_mcap_recording(folder / "a.mcap", compression);
  };
  return {compression.empty() ? "mcap" : "mcap_" + compression, write,
          [](const fs::path& folder) { read_bag(folder / "a.mcap"); }};
}

bool is_sound(const Pose& pose) {
  return is_finite(pose) && std::abs(pose.rotation.norm() - 1.0) < 0.5;
}

void read_session(const fs::path& folder) {
  const auto session = session::Session::open(folder, session::Session::Access::kRead);
  for (const KeyFrame& key_frame : session.key_frames()) {
    require(is_sound(key_frame.T_odom_base), "a pose");
    require(key_frame.motion_covariance.allFinite(), "a covariance");
    session.clouds().cloud(key_frame.index);
  }
  for (const Loop& loop : session.loops()) {
    require(is_sound(loop.T_from_to) && loop.covariance.allFinite(), "a loop");
  }
  for (const auto& pose : session.poses().poses) require(is_sound(pose.T_map_base), "a pose");
  for (const auto& scan : session.odometry()) require(is_sound(scan.T_odom_base), "odometry");
  for (const auto& fix : session.gnss()) {
    require(fix.p_enu_antenna.allFinite() && fix.covariance.allFinite(), "a fix");
  }
  session.verdicts();
  session.imu();
  session.floors();
  session.scans();
  session.revisions();
  session.run_id();
  if (const auto datum = session.datum()) {
    require(std::abs(datum->latitude_deg) <= 90.0, "a latitude");
    require(std::isfinite(datum->longitude_deg) && std::isfinite(datum->altitude_m), "a datum");
  }
  if (const auto origin = session.sensor_origin()) require(origin->allFinite(), "an origin");
  session.configurations();
}

Kind pcd(const std::string& data, bool times) {
  return {"pcd_" + data + (times ? "_times" : ""),
          [=](const fs::path& folder) { write_pcd(folder / "a.pcd", data, times); },
          [](const fs::path& folder) {
            session::read_pcd(folder / "a.pcd");
            try {
              recordings::read_pcd_scan(folder / "a.pcd", 0, {});
            } catch (const InputError&) {
            }
          }};
}

Kind g2o(bool planar) {
  return {planar ? "g2o_planar" : "g2o",
          [=](const fs::path& folder) { write_g2o(folder / "a.g2o", planar); },
          [](const fs::path& folder) {
            const auto file = pose_graph::read_g2o(folder / "a.g2o");
            for (const auto& node : file.graph.nodes) require(is_finite(node.pose), "a vertex");
          }};
}

Kind binary_graph(bool planar) {
  return {planar ? "lmg_planar" : "lmg",
          [=](const fs::path& folder) { write_binary_graph(folder / "a.lmg", planar); },
          [](const fs::path& folder) {
            const auto graph = pose_graph::read_binary_graph(folder / "a.lmg");
            for (const auto& node : graph.nodes) require(is_finite(node.pose), "a vertex");
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

/// The files of all stages, one with a sensor and a preset that goes over it.
void write_parameters(const fs::path& folder) {
  fs::create_directory(folder / "config");
  for (const auto& [stage, yaml] : tools::read_stage_files({}).texts) {
    write_content(folder / "config" / (stage + ".yaml"), yaml);
  }
  write_content(folder / "sensor.yaml",
                "preprocessing:\n  scan_stamp: START\n  scan_period: 0.1\n  "
                "distance_near_thresh: 1.5\nnodes:\n  queue_size: 5\n");
  write_content(folder / "preset.yaml",
                "front_end:\n  voxel_size: 0.8\nloop_closing:\n  voxel_filter:\n    map:\n      "
                "leaf_size: 0.2\nback_end:\n  floor_constraint: neighbours\nmap:\n  "
                "resolution: 0.05\n");
}

Kind parameters() {
  return {"parameters", write_parameters, [](const fs::path& folder) {
            tools::read_stage_files(
                {folder / "config", folder / "sensor.yaml", folder / "preset.yaml", {}});
          }};
}

Kind stage_file() {
  return {"yaml",
          [](const fs::path& folder) {
            write_content(folder / "back_end.yaml", config::to_yaml(back_end::BackEndConfig()));
          },
          [](const fs::path& folder) {
            config::load_file<back_end::BackEndConfig>(folder / "back_end.yaml");
          }};
}

Kind loop_list() {
  return {"loop_list", [](const fs::path& folder) { write_loop_list(folder / "loops.txt"); },
          [](const fs::path& folder) {
            for (const auto& edit : session::read_loop_list(folder / "loops.txt")) {
              require(!edit.guess || is_finite(*edit.guess), "a guess");
            }
          }};
}

Kind hdl_dump() {
  return {"hdl_dump", [](const fs::path& folder) { write_hdl_dump(folder / "dump"); },
          [](const fs::path& folder) {
            auto session = session::Session::create_in(folder / "session");
            pipeline::read_hdl_dump(folder / "dump", session);
            read_session(folder / "session");
          }};
}

/// Tiles of all encodings, their list, and the datum.
void write_map(const fs::path& folder) {
  std::string list = "x_resolution: 20.0\ny_resolution: 20.0\n";
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    const std::string name = std::string(data) + ".pcd";
    write_pcd(folder / name, data, false);
    list += name + ": [0.0, 0.0]\n";
  }
  write_content(folder / "pointcloud_map_metadata.yaml", list);
  write_content(folder / "map_projector_info.yaml",
                "projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_origin:\n"
                "  latitude: 49.0\n  longitude: 8.4\n  altitude: 110.0\n");
}

Kind map_to_import() {
  return {"map_to_import", write_map, [](const fs::path& folder) {
            if (const auto datum = map_import::datum_beside(folder)) {
              require(is_place(*datum), "a datum");
            }
            for (const fs::path& file : map_import::map_files(folder)) {
              map_import::read_points(file, [](const std::vector<map_import::MapPoint>& points) {
                for (const map_import::MapPoint& point : points) {
                  require(point.p_map.norm() < 1e10, "a place beyond the Moon");
                  require(std::isfinite(point.intensity), "an intensity");
                }
              });
            }
          }};
}

Kind campaign_cases() {
  return {"campaign_cases",
          [](const fs::path& folder) {
            std::string lines;
            for (const auto& example : campaign::usual_cases())
              lines += campaign::to_line(example) + "\n";
            lines += "walk drive=tunnel lidar=os1_64 seed=7 start=3.5 scan_rate=5 every=2\n";
            write_content(folder / "cases.txt", lines);
          },
          [](const fs::path& folder) {
            for (const auto& example : campaign::read_cases(folder / "cases.txt")) {
              require(example.every >= 1 && example.every <= 1000, "every");
              require(example.start >= 0.0 && example.start < 1e6, "a start");
              require(example.scan_rate > 0.0 && example.scan_rate < 1e4, "a rate");
              require(example.range_noise >= 0.0 && example.range_noise < 100.0, "a noise");
            }
          }};
}

Kind doubt() {
  return {"doubt", [](const fs::path& folder) { write_doubtful_stretches(folder / "doubt.csv"); },
          [](const fs::path& folder) {
            const auto found = pipeline::read_doubt(folder / "doubt.csv");
            require(std::isfinite(found.path_length), "the length of a drive");
            for (const auto& section : found.sections) {
              require(section.position.allFinite() && std::isfinite(section.path_length),
                      "a section");
              require(section.expected_error >= 0.0, "an error");
            }
          }};
}

Kind run_record() {
  return {"run_record",
          [](const fs::path& folder) {
            report::RunRecord record;
            record.software = "lidar_mapping 0.1.0";
            record.command = "map_bag drive.bag -o town";
            record.files = {{"drive.bag", 123456789, "85944171f73967e8"}};
            record.begin = 1'700'000'000'000'000'000;
            record.end = 1'700'000'160'000'000'000;
            record.topics = {{"points", "/points"}, {"imu", "/imu"}};
            record.sensors = {"points: /points"};
            report::write_run_record(folder, record);
          },
          [](const fs::path& folder) {
            const auto record = report::read_run_record(folder);
            require(record && std::isfinite(record->start), "a time");
            require(std::isfinite(record->sensor_height), "a height");
          }};
}

Kind localized_drive() {
  return {"localized_drive",
          [](const fs::path& folder) {
            write_session(folder / "s");
            write_localized_drive(folder / "drive", folder / "s");
          },
          [](const fs::path& folder) {
            const auto session =
                session::Session::open(folder / "s", session::Session::Access::kRead);
            const auto drive =
                report::read_examined_drive(folder / "drive", session.poses(), folder / "s");
            require(!drive.scans.empty(), "a drive without scans");
            for (const auto& scan : drive.scans) {
              require(is_sound(scan.T_map_base) && is_sound(scan.T_odom_base), "a pose");
              require(scan.agreement >= 0.0 && scan.agreement <= 1.0, "an agreement");
              require(scan.path >= 0.0 && scan.path < 1e10, "a path");
            }
          },
          {},
          "drive/"};
}

/// As receivers send them; a bag's message holds one.
Kind sentences() {
  return {"nmea",
          [](const fs::path& folder) {
            write_content(folder / "sentences.txt",
                          "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\n"
                          "$GNGGA,101530.00,3345.120,S,07036.500,W,4,12,0.7,520.1,M,28.3,M,1,0\n");
          },
          [](const fs::path& folder) {
            std::ifstream file(folder / "sentences.txt");
            for (std::string line; std::getline(file, line);) {
              const auto fix = preprocessing::fix_of_nmea(line, 1);
              if (!fix) continue;
              require(std::abs(fix->latitude_deg) <= 90.0, "a latitude");
              require(std::abs(fix->longitude_deg) <= 180.0, "a longitude");
              // An empty field is a position in the plane, whose altitude is not a number.
              require(!std::isinf(fix->altitude_m), "an altitude");
            }
          }};
}

std::vector<Kind> kinds() {
  const auto session = [](const fs::path& folder) { write_session(folder / "s"); };
  const auto read = [](const fs::path& folder) { read_session(folder / "s"); };
  return {bag("bag_plain", CompressionType::Uncompressed),
          bag("bag_bz2", CompressionType::BZ2),
          bag("bag_lz4", CompressionType::LZ4),
          {"bag_other_types",
           [](const fs::path& folder) { write_bag_of_other_types(folder / "a.bag"); },
           [](const fs::path& folder) { read_bag(folder / "a.bag"); }},
          bag_of("livox"),
          bag_of("velodyne"),
          bag_of("hesai"),
          bag_of("pandar"),
          bag_of("ouster"),
          bag_of("point_cloud1"),
          bag_of("split_times"),
          velodyne_calibration(),
          hesai_calibration(),
          ros2(),
          mcap(""),
          mcap("lz4"),
          mcap("zstd"),
          {"session", session, read},
          {"session_cells", session, read, spoil_session, "session.db"},
          pcd("ascii", false),
          pcd("binary", false),
          pcd("binary_compressed", false),
          pcd("binary", true),
          stage_file(),
          parameters(),
          g2o(false),
          g2o(true),
          binary_graph(false),
          binary_graph(true),
          trajectory(false),
          trajectory(true),
          loop_list(),
          hdl_dump(),
          {"kitti_raw", write_kitti_raw, read_folder},
          {"kitti_raw_text", write_kitti_raw_text, read_folder},
          {"kitti_odometry", write_kitti_odometry, read_folder},
          {"scan_folder", write_scan_folder, read_folder},
          campaign_cases(),
          map_to_import(),
          doubt(),
          run_record(),
          localized_drive(),
          sentences()};
}

}  // namespace

const std::vector<ReaderKind>& reader_kinds() {
  static const std::vector<ReaderKind> all = kinds();
  return all;
}

std::vector<fs::path> files_to_spoil(const ReaderKind& kind, const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path file = fs::relative(entry.path(), folder);
    const bool is_wanted = file.string().find(kind.spoilt) != std::string::npos;
    if (entry.is_regular_file() && is_wanted) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace lidar_mapping::test
