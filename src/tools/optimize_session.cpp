// SPDX-License-Identifier: BSD-3-Clause
// Solves the pose graph of a session again, with other settings if wanted.

#include <chrono>
#include <cstdio>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "lidar_mapping/pipeline/loop_edits.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"

#include "command_line/run_command.hpp"
#include "parameters/drive_config.hpp"

namespace {

using namespace lidar_mapping;
using back_end::BackEndConfig;
using session::Session;

struct Options {
  std::string session;
  std::string config;
  std::vector<std::string> parameters;
  std::string use_gnss;
  std::string use_loops;
  std::string loops;
  std::string output;
};

/// Parameters of the drive, overridden by the file and then by single parameters.
BackEndConfig make_config(const Options& options, const Session& session) {
  auto sources = tools::drive_sources<BackEndConfig>(
      session, tools::only_stage_file(options.config, "back_end"));
  for (const std::string& parameter : options.parameters) {
    sources.push_back(config::parse_yaml(parameter, "--parameter"));
  }
  if (!options.use_gnss.empty()) {
    sources.push_back(config::parse_yaml("use_gnss: " + options.use_gnss, "--use-gnss"));
  }
  if (!options.use_loops.empty()) {
    sources.push_back(config::parse_yaml("use_loop_close: " + options.use_loops, "--use-loops"));
  }
  return config::load<BackEndConfig>(sources);
}

/// The edits of the list of loops; none without a list.
std::vector<Loop> decided_loops(const Options& options, const Session& session) {
  if (options.loops.empty()) return {};
  using loop_closing::LoopClosingConfig;
  const auto config = pipeline::stored_config<LoopClosingConfig>(session);
  const auto decided =
      pipeline::edited_loops(session, session::read_loop_list(options.loops), config);
  for (const Loop& loop : decided) {
    std::printf("loop %u %u: %s%s\n", loop.from, loop.to, to_string(loop.decision),
                loop.source == LoopSource::kManual ? " (added by hand)" : "");
  }
  return decided;
}

void print(const back_end::OptimizationReport& report, const Session& session,
           const std::filesystem::path& directory) {
  std::printf("%s\n", report.message.c_str());
  std::printf("key frames %zu, loops used %zu, refused %zu, GNSS used %zu, refused %zu\n",
              report.key_frames, report.loops_used, report.loops_refused, report.gnss_used,
              report.gnss_refused);
  std::printf("cost %.6g -> %.6g, %.2f s\n", report.cost_before, report.cost_after, report.seconds);
  if (const auto datum = session.datum(); datum && report.gnss_rms > 0.0) {
    std::printf("datum %.9f %.9f deg, %.3f m\n", datum->latitude_deg, datum->longitude_deg,
                datum->altitude_m);
  }
  std::printf("trajectories in %s\n", (directory / "trajectory").c_str());
}

/// Writes the results to another folder; the session stays unchanged.
bool solve_aside(const Options& options) {
  const Session session = Session::open(options.session, Session::Access::kRead);
  back_end::BackEnd back_end(make_config(options, session));
  pipeline::replay(
      session, pipeline::replace_loops(session.loops(), decided_loops(options, session)), back_end);
  const auto begin = std::chrono::steady_clock::now();
  const auto solution = back_end::solve(*back_end.problem(true));
  back_end::OptimizationReport report = back_end::report_of(*solution);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const KeyFramePoses poses = back_end.apply(*solution);
  pipeline::write_results(session, back_end, poses, options.output);
  print(report, session, options.output);
  return report.success;
}

/// Adds a new revision of the poses to the session: that of the solution with which it is opened.
bool solve_inside(const Options& options) {
  Session session = Session::open(options.session, Session::Access::kWrite);
  const BackEndConfig config = make_config(options, session);
  pipeline::store_decisions(session, decided_loops(options, session));
  pipeline::RecordedBackEnd back_end(std::move(session), config);
  back_end.write_files();
  print(back_end.opening_report(), back_end.session(), back_end.session().directory());
  return back_end.opening_report().success;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Solves the pose graph of a session again"};
  Options options;
  app.add_option("session", options.session, "folder of the session, or a folder with `latest`")
      ->required();
  app.add_option("--use-gnss", options.use_gnss, "true or false; as in the drive if left out");
  app.add_option("--use-loops", options.use_loops, "true or false; as in the drive if left out");
  app.add_option("--loops", options.loops,
                 "list of loops to accept, refuse or add, as loops.txt of the session");
  app.add_option("--config", options.config,
                 std::string(tools::kConfigHelp) + "; parameters of the back end");
  app.add_option("--parameter", options.parameters, "a single one, as 'name: value' (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--output", options.output,
                 "write the results here and leave the session as it is");
  return tools::run_command(app, argc, argv, [&] {
    return (options.output.empty() ? solve_inside(options) : solve_aside(options)) ? 0 : 1;
  });
}
