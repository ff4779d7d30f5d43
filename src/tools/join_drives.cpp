// SPDX-License-Identifier: BSD-3-Clause
// Joins many drives step by step, each step from files to files: the jobs of map_city.

#include <cstdio>
#include <filesystem>
#include <set>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/folder_entries.hpp"

#include "city_files.hpp"
#include "city_session.hpp"
#include "command_line/run_command.hpp"
#include "parameters/drive_config.hpp"

namespace {

namespace fs = std::filesystem;
using namespace lidar_mapping;
using session::Session;

struct Options {
  std::vector<std::string> inputs;
  std::string sessions;
  std::string loops;
  std::vector<double> datum;
  std::string config;
  std::string output;
};

Session opened(const fs::path& folder) { return Session::open(folder, Session::Access::kRead); }

void check_names(const std::vector<std::string>& names) {
  std::set<std::string> known;
  for (const std::string& name : names) {
    if (known.insert(name).second) continue;
    throw InputError("two drives have the name '" + name +
                     "'; give the folders of the sessions different names");
  }
}

void describe(const Options& options) {
  const std::string& folder = options.inputs.front();
  const auto drive = city::describe_drive(opened(folder), city::drive_name(folder));
  city::write_pieces(drive, options.output);
  std::printf("%s: %zu pieces\n", drive.drive.c_str(), drive.pieces.size());
}

void pair(const Options& options) {
  std::vector<city::DrivePieces> drives;
  std::vector<std::string> names;
  for (const std::string& path : options.inputs) {
    drives.push_back(city::read_pieces(path));
    names.push_back(drives.back().drive);
  }
  check_names(names);
  const auto chunks = city::find_chunks(drives);
  city::write_chunks(chunks, options.output);
  for (const city::Chunk& chunk : chunks) std::printf("%s\n", chunk.id.c_str());
  std::printf("%zu drives, %zu chunks to search\n", drives.size(), chunks.size());
}

void search(const Options& options) {
  const city::Chunk chunk = city::read_chunk(options.inputs.front());
  const fs::path folder = options.sessions;
  const Session a = opened(folder / chunk.a), b = opened(folder / chunk.b);
  const auto found = city::search_chunk(
      a, b, chunk, tools::drive_config<back_end::BackEndConfig>(a, options.config),
      tools::drive_config<loop_closing::LoopClosingConfig>(a, options.config),
      fs::temp_directory_path());
  city::write_loops(found, options.output);
  std::printf("%s: %zu key frames searched for, %zu candidates, %zu loops\n", chunk.id.c_str(),
              found.searched, found.verdicts.size(), found.loops.size());
}

/// The files of loops in a folder, in the order of their names.
std::vector<city::PairLoops> loops_in(const std::string& folder) {
  if (folder.empty()) return {};
  const std::vector<fs::path> files = sorted_paths_in(
      folder, [](const fs::directory_entry& entry) { return entry.path().extension() == ".json"; });
  std::vector<city::PairLoops> loops;
  for (const fs::path& file : files) loops.push_back(city::read_loops(file));
  return loops;
}

void print(const city::JoinedDrive& drive) {
  std::printf("%s: %s, %zu key frames, loops to other drives: %zu used, %zu refused\n",
              drive.name.c_str(), to_string(drive.state), drive.key_frames.size(), drive.loops.used,
              drive.loops.refused);
  for (const std::string& notice : drive.notices) std::printf("  %s\n", notice.c_str());
}

void join(const Options& options) {
  std::vector<std::string> names;
  for (const std::string& path : options.inputs) names.push_back(city::drive_name(path));
  check_names(names);
  const auto config =
      tools::drive_config<back_end::BackEndConfig>(opened(options.inputs.front()), options.config);
  std::optional<GeodeticDatum> datum;
  if (!options.datum.empty()) datum = {options.datum[0], options.datum[1], options.datum[2]};
  const city::JoinedCity joined = city::join_drives({options.inputs.begin(), options.inputs.end()},
                                                    loops_in(options.loops), datum, config);
  city::write_city(joined, config, options.output);
  city::write_joined(joined, fs::path(options.output) / "city.json");
  for (const city::JoinedDrive& drive : joined.drives) print(drive);
}

CLI::App* add_step(CLI::App& app, const std::string& name, const std::string& text,
                   const std::string& inputs, Options& options, void (*run)(const Options&)) {
  CLI::App* step = app.add_subcommand(name, text);
  step->add_option("inputs", options.inputs, inputs)->required();
  step->add_option("-o,--output", options.output, "what to write")->required();
  step->callback([&options, run] { run(options); });
  return step;
}

void add_arguments(CLI::App& app, Options& options) {
  const auto with_config = [&options](CLI::App* step) {
    step->add_option("--config", options.config,
                     std::string(tools::kConfigHelp) +
                         " (back_end, loop_closing); as in the first drive if left out");
  };
  add_step(app, "describe", "pieces of a drive, their boxes and appearance, to a file",
           "folder of the session", options, describe)
      ->get_option("inputs")
      ->expected(1);
  add_step(app, "pairs", "which stretches of which drives to search, a file for each chunk",
           "files of describe, a drive each", options, pair);
  CLI::App* loops = add_step(app, "loops", "searches the loops of a chunk",
                             "file of the chunk, of pairs", options, search);
  loops->get_option("inputs")->expected(1);
  loops->add_option("--sessions", options.sessions, "folder of the sessions of the drives")
      ->required();
  with_config(loops);
  CLI::App* graph = add_step(app, "graph", "one pose graph and one session of all drives",
                             "folders of the sessions", options, join);
  graph->add_option("--loops", options.loops, "folder of the files of loops");
  graph
      ->add_option("--datum", options.datum,
                   "origin of the map: latitude and longitude in degrees, height in m; that of the "
                   "first drive that has one if left out")
      ->expected(3);
  with_config(graph);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Joins many drives step by step, each step from files to files"};
  app.require_subcommand(1);
  Options options;
  add_arguments(app, options);
  return tools::run_command(app, argc, argv, [] {});  // each step is a callback
}
