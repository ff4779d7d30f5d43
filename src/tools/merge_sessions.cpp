// SPDX-License-Identifier: BSD-3-Clause
// Merges sessions by loops between them or by GNSS.

#include <cstdio>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/session_merger.hpp"

#include "command_line/run_command.hpp"
#include "parameters/drive_config.hpp"

namespace {

using namespace lidar_mapping;
using session::Session;

struct Options {
  std::vector<std::string> sessions;
  std::string output;
  std::string config;
};

void print(const pipeline::MergedSession& part, const std::string& name) {
  std::printf("%s: key frames %u to %zu, %zu new loops\n", name.c_str(), part.first,
              part.first + part.key_frames - 1, part.new_loops);
  if (part.stamp_offset != 0) {
    std::printf("  its stamps were moved by %lld ns, because another session has the same ones\n",
                static_cast<long long>(part.stamp_offset));
  }
  for (const std::string& notice : part.notices) std::printf("  %s\n", notice.c_str());
}

/// Throws if a session is not connected to the first one.
void check_joined(const Options& options, const std::vector<pipeline::MergedSession>& parts) {
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].is_connected) continue;
    const std::string pair = std::to_string(parts[0].first) + " " + std::to_string(parts[i].first);
    throw InputError(
        "neither a loop nor GNSS connects " + options.sessions[i] + " to " + options.sessions[0] +
        ", so " + options.output +
        " contains both without a connection; write a line such as 'add " + pair +
        "' into a file LIST, with the numbers of two key frames at the same place, and "
        "run optimize_session " +
        options.output + " --loops LIST");
  }
}

/// Throws if a session would be merged with itself, or if --config has no file that is used.
void check_arguments(const Options& options) {
  namespace fs = std::filesystem;
  std::error_code none;
  for (std::size_t i = 0; i < options.sessions.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!fs::equivalent(options.sessions[k], options.sessions[i], none)) continue;
      throw InputError(options.sessions[i] + " is given twice; name each drive once");
    }
  }
  if (options.config.empty() || !tools::stage_file(options.config, "back_end").empty() ||
      !tools::stage_file(options.config, "loop_closing").empty()) {
    return;
  }
  throw FileError("there is no back_end.yaml nor loop_closing.yaml in " + options.config +
                  "; --config names a " + tools::kConfigHelp);
}

void merge(const Options& options) {
  check_arguments(options);
  std::vector<Session> sessions;
  for (const std::string& name : options.sessions) {
    sessions.push_back(Session::open(name, Session::Access::kRead));
  }
  using loop_closing::LoopClosingConfig;
  pipeline::SessionMerger merge(
      Session::create_in(options.output),
      tools::drive_config<back_end::BackEndConfig>(sessions.front(), options.config),
      tools::drive_config<LoopClosingConfig>(sessions.front(), options.config));
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    merge.add(sessions[i]);
    print(merge.parts().back(), options.sessions[i]);
    std::fflush(stdout);
  }
  merge.finish();
  check_joined(options, merge.parts());
  std::printf("merged session in %s\n", options.output.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Merges sessions into one, by loops between them or by GNSS; the given sessions are not "
      "changed"};
  Options options;
  app.add_option("sessions", options.sessions, "folders of two or more sessions")
      ->required()
      ->expected(2, 1000);
  app.add_option("-o,--output", options.output, "folder for the new session")->required();
  app.add_option("--config", options.config,
                 std::string(tools::kConfigHelp) +
                     " (back_end, loop_closing); as in the first drive if left out");
  return tools::run_command(app, argc, argv, [&] { merge(options); });
}
