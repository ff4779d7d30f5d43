// SPDX-License-Identifier: BSD-3-Clause
// Checks the sensors' messages in bags and reports faults with their remedies.

#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/recording_check.hpp"

#include "bag_paths.hpp"
#include "command_line/run_command.hpp"
#include "parameters/stage_files.hpp"
#include "recording/drive_arguments.hpp"

namespace {

using namespace lidar_mapping;

struct Options {
  std::vector<std::string> bags;
  tools::ParameterSources parameters;
  std::string base_frame;  ///< empty: that of the parameters
  ros_border::SensorTopics topics;
};

void add_arguments(CLI::App& app, Options& options) {
  app.add_option("bags", options.bags,
                 "bags of one drive (ROS 1, or .db3 or .mcap of ROS 2), or a folder of them")
      ->required();
  tools::add_parameter_options(app, options.parameters);
  app.add_option("--base-frame", options.base_frame,
                 "frame of the vehicle; that of the parameters if left out");
  tools::add_topic_options(app, options.topics);
}

void print(const preprocessing::InputReport& report, const std::string& topic) {
  std::printf("%-9s %s%s%s\n", report.input.c_str(), topic.c_str(), topic.empty() ? "" : ": ",
              report.found.c_str());
  for (const preprocessing::CheckDiagnostic& diagnostic : report.diagnostics) {
    std::printf("  %-8s%s\n           remedy: %s\n", preprocessing::to_string(diagnostic.severity),
                diagnostic.text.c_str(), diagnostic.remedy.c_str());
  }
}

/// Prints a line for each input and its faults; true if there are no faults.
bool run(const Options& options) {
  const tools::StageFiles stages = tools::read_stage_files(options.parameters);
  const ros_border::BagSet bags(recordings::with_bags_of_folders(options.bags));
  ros_border::RecordingCheck recording;
  recording.bags = &bags;
  recording.base_frame = options.base_frame.empty() ? stages.base_frame : options.base_frame;
  recording.topics = ros_border::topics_in(bags, options.topics);
  const std::vector<std::string> topics = recording.topics.by_sensor();
  std::size_t diagnostics = 0, index = 0;
  for (const auto& report : ros_border::check(recording, stages.pipeline.preprocessing)) {
    print(report, topics[index++]);
    diagnostics += report.diagnostics.size();
  }
  return diagnostics == 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Checks the sensors' messages in bags and reports faults with their remedies"};
  app.footer(
      "The parameters are those that map_bag would get: what they mend is no fault any more. Ends "
      "with 0 if nothing is wrong, 1 if something is, 2 if a bag cannot be read.");
  add_arguments(app, options);
  return tools::run_command(
      app, argc, argv, [&] { return run(options) ? 0 : 1; }, 2);
}
