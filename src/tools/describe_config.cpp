// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"

#include "command_line/run_command.hpp"
#include "parameters/config_documents.hpp"

namespace lidar_mapping::tools {
namespace {

void print(const std::string& stage, bool markdown) {
  for (const ConfigDocument& document : config_documents()) {
    if (!stage.empty() && document.stage != stage) continue;
    if (markdown && stage.empty()) std::cout << "\n### " << document.stage << "\n\n";
    std::cout << (markdown ? document.markdown : document.yaml);
  }
}

std::vector<std::string> stages() {
  std::vector<std::string> names;
  for (const ConfigDocument& document : config_documents()) names.push_back(document.stage);
  return names;
}

void run(const std::string& stage, bool markdown, const std::string& folder) {
  if (folder.empty()) return print(stage, markdown);
  for (const ConfigDocument& document : config_documents()) {
    write_text_atomically(std::filesystem::path(folder) / (document.stage + ".yaml"),
                          document.yaml);
  }
}

}  // namespace
}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app("Prints the parameters of a stage, or of all: name, default, range, meaning.");
  std::string stage;
  bool markdown = false;
  std::string folder;
  app.add_option("stage", stage, "All stages if left out")->check(CLI::IsMember(tools::stages()));
  app.add_flag("--markdown", markdown, "A table instead of a YAML file");
  app.add_option("--write", folder, "Write the default file of each stage into this folder")
      ->check(CLI::ExistingDirectory);
  return tools::run_command(app, argc, argv, [&] { tools::run(stage, markdown, folder); });
}
