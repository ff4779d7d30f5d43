// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"

#include "parameters/config_documents.hpp"

namespace lidar_mapping::tools {
namespace {

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw FileError("cannot write " + path.string());
}

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

int run(int argc, char** argv) {
  CLI::App app("Prints the parameters of a stage, or of all: name, default, range, meaning.");
  std::string stage;
  bool markdown = false;
  std::string folder;
  app.add_option("stage", stage, "All stages if left out")->check(CLI::IsMember(stages()));
  app.add_flag("--markdown", markdown, "A table instead of a YAML file");
  app.add_option("--write", folder, "Write the default file of each stage into this folder")
      ->check(CLI::ExistingDirectory);
  CLI11_PARSE(app, argc, argv);
  if (folder.empty()) {
    print(stage, markdown);
  } else {
    for (const ConfigDocument& document : config_documents()) {
      write_file(std::filesystem::path(folder) / (document.stage + ".yaml"), document.yaml);
    }
  }
  return 0;
}

}  // namespace
}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  try {
    return lidar_mapping::tools::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "describe_config: %s\n", error.what());
    return 1;
  }
}
