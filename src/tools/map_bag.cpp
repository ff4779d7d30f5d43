// Maps a recorded drive without a ROS master, as fast as the processor allows.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"

#include "bag_input.hpp"
#include "map_output.hpp"
#include "stage_files.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string config;
  std::string sensor;
  SensorTopics topics;
  int threads = 0;
  ProductOptions products;
};

void add_arguments(CLI::App& app, Options& options) {
  app.add_option("input", options.inputs, "bags of one drive")->required();
  app.add_option("-o,--output", options.output, "new folder for the session and the map")
      ->required();
  app.add_option("--config", options.config, "folder of <stage>.yaml; defaults if left out");
  app.add_option("--sensor", options.sensor,
                 "overlay of parameters, such as those of config/sensors");
  app.add_option("--points", options.topics.points, "topic (found by its type if left out)");
  app.add_option("--imu", options.topics.imu, "topic");
  app.add_option("--velocity", options.topics.velocity, "topic");
  app.add_option("--gnss", options.topics.gnss, "topic");
  app.add_option("--threads", options.threads, "at most so many threads; 0: all cores")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--formats", options.products.formats, "products of build_map")
      ->delimiter(',')
      ->check(CLI::IsMember(product_formats()));
  app.add_option("--resolution", options.products.resolution, "edge of the map's voxels, m");
  app.add_flag("--keep-moving", options.products.keep_moving,
               "leave points of moving objects in the map");
}

void run(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  StageFiles stages = read_stage_files(options.config, options.sensor);
  stages.pipeline.threads = options.threads;
  BagInput input(options.inputs, options.topics, stages.base_frame, stages.pipeline.preprocessing);
  auto session = session::Session::create_in(options.output);
  for (const auto& [stage, text] : stages.texts) session.set_configuration(stage, text);
  pipeline::Pipeline pipeline(stages.pipeline, std::move(session),
                              [&](const std::string& frame) { return input.T_base(frame); });
  const pipeline::ThreadTime reading_time;
  while (auto datum = input.next()) pipeline.add(std::move(*datum));
  const double reading = reading_time.seconds();
  const auto since = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const double streamed = since();
  const pipeline::PipelineReport report = pipeline.finish();
  const double mapped = since();
  for (const auto& notice : pipeline.take_notices()) std::printf("%s\n", notice.c_str());
  std::printf("%zu scans, %zu key frames, %zu loops\n", report.progress.scans,
              report.progress.key_frames, report.progress.loops);
  write_products(pipeline.session(), options.products);
  std::printf("reading %.1f s\n", reading);
  for (const auto& [name, seconds] : report.stage_seconds) {
    std::printf("%s %.1f s\n", name.c_str(), seconds);
  }
  const double driven = to_seconds(input.end() - input.begin());
  std::printf("%.1f s driven; streamed %.1f, optimised %.1f, all %.1f s: %.1f x\n", driven,
              streamed, mapped, since(), driven / since());
}

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Maps a recorded drive without a ROS master, as fast as the processor allows"};
  tools::Options options;
  tools::add_arguments(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    tools::run(options);
  } catch (const Error& error) {
    std::cerr << "map_bag: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
