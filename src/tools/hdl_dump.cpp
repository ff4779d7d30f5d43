// SPDX-License-Identifier: BSD-3-Clause
// Sessions to the folders that hdl_graph_slam dumps and interactive_slam edits, and back.

#include "lidar_mapping/pipeline/hdl_dump.hpp"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "command_line/run_command.hpp"

namespace {

using namespace lidar_mapping;
using session::Session;

void export_dump(const std::string& name, const std::string& directory) {
  const Session session = Session::open(name, Session::Access::kRead);
  back_end::BackEnd back_end(pipeline::stored_config<back_end::BackEndConfig>(session));
  pipeline::replay(session, back_end);
  back_end.apply(*back_end::solve(*back_end.problem(true)));
  const pose_graph::PoseGraph graph = back_end.graph();
  pipeline::write_hdl_dump(session, graph, back_end.in_enu(), directory);
  std::printf("%zu key frames, %zu edges in %s\n", graph.nodes.size(), graph.edges.size(),
              directory.c_str());
}

void import_dump(const std::string& directory, const std::string& name) {
  pipeline::HdlImport imported;
  session::create_filled(
      name, [&](Session& session) { imported = pipeline::read_hdl_dump(directory, session); });
  std::printf("%zu key frames in %zu segments, %zu loops in %s\n", imported.key_frames,
              imported.segments, imported.loops, name.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Sessions to folders as hdl_graph_slam dumps them, for interactive_slam, and back"};
  app.require_subcommand(1);
  std::string from;
  std::string to;
  CLI::App* out = app.add_subcommand("export", "a session to a dump folder");
  out->add_option("session", from, "folder of the session, or a folder with `latest`")->required();
  out->add_option("-o,--output", to, "folder that does not exist yet")->required();
  CLI::App* in = app.add_subcommand("import", "a dump folder to a session");
  in->add_option("dump", from, "the folder with graph.g2o")->required();
  in->add_option("-o,--output", to, "folder for the session")->required();
  return tools::run_command(app, argc, argv,
                            [&] { *out ? export_dump(from, to) : import_dump(from, to); });
}
