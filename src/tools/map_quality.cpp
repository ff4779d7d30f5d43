// SPDX-License-Identifier: BSD-3-Clause
// Measures the quality of the map of a session, without truth; as text, JSON or a report in HTML.

#include "lidar_mapping/map_quality/map_quality.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/map/map_builder.hpp"
#include "lidar_mapping/map/top_view.hpp"

#include "command_line/child_program.hpp"
#include "command_line/number_checks.hpp"
#include "command_line/run_command.hpp"
#include "examined_drive.hpp"
#include "place_pictures.hpp"
#include "report_examination.hpp"
#include "report_figures.hpp"

namespace {

using namespace lidar_mapping;
using json::Json;
using session::Session;

struct Options {
  std::string session;
  std::string json;
  std::string key_frames;
  std::string truth;
  std::vector<std::string> examined_by;  ///< folders of localize_bag
  double range_noise = 0.02;
  std::size_t places = 10;
  std::vector<double> sensor_origin;
  bool report = false;
};

constexpr std::size_t kPictures = 6;  // places with pictures; chosen: a person looks at no more

/// Sensor origin from the command line, or else from the session.
std::optional<Eigen::Vector3d> sensor_origin_of(const Options& options, const Session& session) {
  if (options.sensor_origin.size() == 3) return Eigen::Vector3d(options.sensor_origin.data());
  return session.sensor_origin();
}

struct QualityResult {
  map_quality::LocalThickness thickness;
  std::vector<map_quality::PassMisalignment> misalignments;  ///< worst first
  bool has_ratio = false;
};

QualityResult quality_of(const report::ReportInput& input,
                         const map_quality::QualityConfig& config) {
  CloudSource& clouds = input.session.clouds();
  QualityResult result{map_quality::local_thickness(input.poses, clouds, config),
                       map_quality::pass_misalignments(input.poses, clouds, config),
                       config.p_base_sensor.has_value()};
  std::stable_sort(result.misalignments.begin(), result.misalignments.end(),
                   [](const auto& a, const auto& b) { return a.distance() > b.distance(); });
  return result;
}

void print(const char* name, const map_quality::Thickness& thickness, bool has_ratio) {
  std::printf("%-7s thickness: median %5.1f mm, 90 %% below %5.1f mm (%zu cells)", name,
              1000.0 * thickness.median, 1000.0 * thickness.percentile_90, thickness.cells);
  has_ratio ? std::printf(", %.2f of the noise\n", thickness.median_ratio) : std::printf("\n");
}

void print(const std::vector<map_quality::PassMisalignment>& misalignments, std::size_t places) {
  if (misalignments.empty()) {
    std::printf("no place was driven twice, so only local quality could be judged\n");
    return;
  }
  std::printf(
      "%zu places were driven twice; position of the later pass relative to the earlier one, worst "
      "first:\n",
      misalignments.size());
  std::printf("  key frame       x       y   along mm  left mm   up mm  yaw deg  planes\n");
  for (std::size_t i = 0; i < std::min(places, misalignments.size()); ++i) {
    const map_quality::PassMisalignment& misalignment = misalignments[i];
    std::printf("  %9u %7.1f %7.1f   %8.1f %8.1f %7.1f  %7.3f  %6zu\n", misalignment.key_frame,
                misalignment.position.x(), misalignment.position.y(), 1000.0 * misalignment.forward,
                1000.0 * misalignment.left, 1000.0 * misalignment.up, misalignment.yaw * kDegPerRad,
                misalignment.planes);
  }
}

void print(const QualityResult& found, std::size_t places) {
  print("ground", found.thickness.ground, found.has_ratio);
  print("wall", found.thickness.walls, found.has_ratio);
  std::printf("planar fraction %.2f\n", found.thickness.planar_fraction);
  print(found.misalignments, places);
}

Json to_json(const QualityResult& found, const map_quality::QualityConfig& config) {
  Json figures = {{"range_noise_m", config.range_noise},
                  {"thickness", report::to_json(found.thickness, found.has_ratio)},
                  {"misalignments", Json::array()}};
  for (const map_quality::PassMisalignment& misalignment : found.misalignments) {
    figures["misalignments"].push_back(report::to_json(misalignment));
  }
  return figures;
}

std::vector<report::ExaminedDrive> read_drives(const Options& options, const Session& session) {
  std::vector<report::ExaminedDrive> drives;
  const KeyFramePoses map = session.poses();
  for (const std::string& folder : options.examined_by) {
    drives.push_back(report::read_examined_drive(folder, map, session.directory()));
  }
  return drives;
}

Json examinations_by(const std::vector<report::ExaminedDrive>& drives, const KeyFramePoses& map) {
  Json examinations = Json::array();
  for (const report::ExaminedDrive& drive : drives) {
    examinations.push_back(report::examination_figures(drive, map));
  }
  return examinations;
}

/// All figures of the drive and its map.
Json report_of(const report::ReportInput& input, const QualityResult& found,
               const map_quality::QualityConfig& config, const back_end::BackEnd& graph,
               const std::vector<back_end::KeyFrameDeviation>& deviations,
               const std::vector<report::ExaminedDrive>& drives) {
  Json report = {{"format", 2},
                 {"session", input.session.directory().filename().string()},
                 {"origin", report::origin_figures(input)},
                 {"products", report::product_figures(input)},
                 {"drive", report::drive_figures(input)}};
  report.update(to_json(found, config));
  report["entropy"] =
      report::to_json(map_quality::mean_map_entropy(input.poses, input.session.clouds()));
  report["trajectory"] = report::trajectory_figures(input);
  report["loops"] = report::loop_figures(input);
  report["gnss"] = report::gnss_figures(input, graph);
  report["scans"] = report::scan_figures(input);
  report["uncertainty"] = report::uncertainty_figures(input, graph, deviations);
  report["doubt"] = report::doubt_figures(input, graph);
  report["examinations"] = examinations_by(drives, input.poses);
  report["truth"] = report::truth_figures(input);
  report["verdicts"] = report::verdicts(report);
  report["overall"] = report::overall_verdict(report);
  return report;
}

/// Writes the files in `directory` that the pictures of the report need beside its figures.
void write_picture_data(const report::ReportInput& input, const QualityResult& found,
                        const map_quality::QualityConfig& config,
                        const std::filesystem::path& directory) {
  CloudSource& clouds = input.session.clouds();
  Json places = Json::array();
  for (std::size_t i = 0; i < std::min(kPictures, found.misalignments.size()); ++i) {
    const auto points =
        map_quality::pass_points(input.poses, clouds, config, found.misalignments[i]);
    places.push_back({{"across", report::place_picture(points, report::View::kAcross)},
                      {"above", report::place_picture(points, report::View::kFromAbove)}});
  }
  write_text_atomically(directory / "places.json", json::dumped(places));
  const auto view = map::top_view(map::build_map(input.poses, clouds, {}), 0.25, 1600);
  map::write_png(directory / "top_view.png", view);
  const Json frame = {view.x_min, view.x_min + view.width * view.pixel_m,
                      view.y_max - view.height * view.pixel_m, view.y_max};
  write_text_atomically(directory / "top_view.json", json::dumped(frame));
}

void print_verdicts(const Json& report) {
  std::printf("%s\n", report["overall"].get<std::string>().c_str());
  for (const Json& warning : report["doubt"]["warnings"]) {
    std::printf("%s\n", warning.get<std::string>().c_str());
  }
  for (const Json& line : report["verdicts"]) {
    const char* judgement = line["good"].is_null() ? "" : line["good"] ? "good" : "look here";
    std::printf("%-9s %-26s %s\n", judgement, line["name"].get<std::string>().c_str(),
                line["value"].get<std::string>().c_str());
  }
}

void write_report(const report::ReportInput& input, const QualityResult& found,
                  const map_quality::QualityConfig& config, const Json& report) {
  const std::filesystem::path directory = input.session.directory();
  write_text_atomically(directory / "report.json", json::dumped(report) + "\n");
  const std::filesystem::path data = directory / ".report";
  std::filesystem::create_directories(data);
  write_picture_data(input, found, config, data);
  const std::filesystem::path page = directory / "report.html";
  tools::run_program(tools::program_beside("make_report.py"),
                     {directory / "report.json", data, page});
  std::filesystem::remove_all(data);
  std::printf("%s\n", page.c_str());
}

void judge(const Options& options) {
  const Session session = Session::open(options.session, Session::Access::kRead);
  // Read first, so that unreadable files are reported at once.
  std::optional<Trajectory> truth;
  if (!options.truth.empty()) truth = read_trajectory(options.truth);
  const std::vector<report::ExaminedDrive> drives = read_drives(options, session);
  map_quality::QualityConfig config;
  config.range_noise = options.range_noise;
  config.p_base_sensor = sensor_origin_of(options, session);
  if (!config.p_base_sensor) {
    std::cerr << "map_quality: the session does not know where the LiDAR is in base_link; give "
                 "--sensor-origin x y z for the ratio to the noise, and to tell the sides of a "
                 "surface apart\n";
  }
  const report::ReportInput input = report::report_input(session, truth);
  const QualityResult found = quality_of(input, config);
  const auto graph = report::solved_graph(session);
  const auto deviations = back_end::key_frame_deviations(*graph->problem(true));
  const Json report = report_of(input, found, config, *graph, deviations, drives);
  print(found, options.places);
  for (const Json& drive : report["examinations"]) {
    std::printf("%s", report::examination_text(drive, options.places).c_str());
  }
  print_verdicts(report);
  if (!options.json.empty()) {
    Json figures = to_json(found, config);
    for (const char* part : {"verdicts", "truth", "uncertainty", "examinations"}) {
      figures[part] = report[part];
    }
    write_text_atomically(options.json, json::dumped(figures, 2) + "\n");
  }
  if (!options.key_frames.empty()) {
    write_text_atomically(options.key_frames, report::key_frame_table(input, deviations));
  }
  if (options.report) write_report(input, found, config, report);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measures the quality of the map of a session, without truth"};
  Options options;
  app.add_option("session", options.session, "folder of the session, or a folder with `latest`")
      ->required();
  app.add_option("--range-noise", options.range_noise,
                 "standard deviation of the sensor's ranges, m; 0.02 if left out")
      ->check(tools::above_zero());
  app.add_option("--places", options.places, "places to print; 10 if left out");
  app.add_option("--sensor-origin", options.sensor_origin, "the LiDAR in base_link, m; as recorded")
      ->expected(3);
  app.add_option(
      "--json", options.json,
      "write thickness, misalignments of passes, examinations, verdicts, uncertainty and errors to "
      "this file");
  app.add_option("--key-frames", options.key_frames,
                 "write how well the graph knows each key frame to this CSV file");
  app.add_flag("--report", options.report, "write report.html and report.json to the session");
  app.add_option("--examined-by", options.examined_by,
                 "folder that localize_bag made of another drive in this map (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--truth", options.truth, "true trajectory (TUM) to compare with");
  return tools::run_command(app, argc, argv, [&] { judge(options); });
}
