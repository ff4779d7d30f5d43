// Maps a recorded drive without a ROS master, as fast as the processor allows.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"
#include "lidar_mapping/pipeline/thread_time.hpp"

#include "drive_input.hpp"
#include "map_output.hpp"
#include "mapping_figures.hpp"
#include "mapping_progress.hpp"
#include "number_checks.hpp"
#include "process_memory.hpp"
#include "stage_files.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;
using session::Session;

constexpr int kFailed = 1;
constexpr int kStoppedEarly = 3;
constexpr int kStoppedAtOnce = 130;

struct Options {
  DriveSelection drive;
  std::string output;
  std::string config;
  std::string sensor;
  std::string figures;
  int threads = 0;
  bool resume = false;
  bool no_map = false;
  bool report = false;
  MapOutput map;
};

volatile std::sig_atomic_t stop_asked = 0;

extern "C" void ask_to_stop(int) {
  if (stop_asked != 0) _exit(kStoppedAtOnce);
  stop_asked = 1;
}

void add_arguments(CLI::App& app, Options& options) {
  app.add_option("input", options.drive.paths,
                 "bags of one drive, or a folder: KITTI raw, KITTI odometry, *.pcd or *.bin")
      ->required();
  app.add_option("-o,--output", options.output, "new folder for the session and the map")
      ->required();
  app.add_option("--config", options.config, "folder of <stage>.yaml; defaults if left out");
  app.add_option("--sensor", options.sensor,
                 "overlay of parameters: a name in config/sensors, or the path of a file");
  app.add_option("--points", options.drive.topics.points, "topic (found by type if left out)");
  app.add_option("--imu", options.drive.topics.imu, "topic");
  app.add_option("--velocity", options.drive.topics.velocity, "topic");
  app.add_option("--gnss", options.drive.topics.gnss, "topic");
  app.add_option("--sensor-height", options.drive.sensor_height,
                 "of folders: the LiDAR over base_link, m")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "at most so many threads; 0: all cores")
      ->check(not_negative());
  app.add_flag("--resume", options.resume, "go on with the session in the output folder");
  app.add_option("--formats", options.map.products.formats, "of the map, as build_map has them")
      ->delimiter(',')
      ->check(CLI::IsMember(map::product_formats()));
  app.add_option("--resolution", options.map.resolution, "edge of the map's voxels, m");
  app.add_flag("--keep-moving", options.map.keep_moving,
               "leave points of moving objects in the map");
  app.add_flag("--no-map", options.no_map, "the session alone; build_map makes a map of it later");
  app.add_flag("--report", options.report,
               "judge the map and write report.html, as map_quality does");
  app.add_option("--figures", options.figures, "write times and counts to this JSON file");
}

/// A process that was killed at once leaves the lock alone.
bool holds_more_than_lock(const fs::path& folder) {
  const fs::directory_iterator entries(folder);
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) { return entry.path().filename() != "lock"; });
}

/// What the folder must be: new or empty, or with --resume a session.
Session open_session(const Options& options) {
  if (options.resume && fs::exists(fs::path(options.output) / "session.db")) {
    return Session::open(options.output, Session::Access::kWrite);
  }
  if (fs::exists(options.output) && !fs::is_directory(options.output)) {
    throw FileError(options.output + " is no folder; name a new one");
  }
  if (fs::exists(options.output) && holds_more_than_lock(options.output)) {
    throw FileError(options.output +
                    " is not empty; name a new folder, or give --resume to go "
                    "on with a session that was broken off");
  }
  return Session::create_in(options.output);
}

/// Another program of this package, which lies beside this one.
void run_beside(const std::string& program, const std::string& words) {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  const std::string command = "'" + (folder / program).string() + "' " + words;
  if (std::system(command.c_str()) != 0) throw FileError("this failed: " + command);
}

class MappingRun {
 public:
  explicit MappingRun(const Options& options)
      : options_(options), stages_(read_stage_files(options.config, options.sensor)) {
    stages_.pipeline.threads =
        options.threads > 0 ? options.threads
                            : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    options_.drive.base_frame = stages_.base_frame;
    options_.map.threads = options.threads;
    check_numbers(options_.map);
  }

  int run() {
    map_recording();
    return conclude();
  }

 private:
  /// Leaves neither the recording's index nor the pipeline behind: the map needs their memory.
  void map_recording() {
    OpenDrive drive = open_drive(options_.drive, stages_.pipeline.preprocessing);
    for (const std::string& line : drive.lines) std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    begin_ = drive.input->begin();
    end_ = drive.input->end();
    progress_ = std::make_unique<MappingProgress>(begin_, end_);
    try {
      map(*drive.input, false);
    } catch (const pipeline::ResumeFailure&) {
      std::printf(
          "going over the whole recording again: its last stretch alone does not lead to "
          "where the session ends\n");
      drive = open_drive(options_.drive, stages_.pipeline.preprocessing);
      map(*drive.input, true);
    }
    pipeline_.reset();
  }

  void map(pipeline::InputSource& input, bool whole) {
    pipeline_.reset();  // lets go of the session
    Session session = open_session(options_);
    for (const auto& [stage, text] : stages_.texts) session.set_configuration(stage, text);
    stages_.pipeline.replay_whole = whole;
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        stages_.pipeline, std::move(session),
        [&input](const std::string& frame) { return input.T_base(frame); });
    if (const auto stamp = pipeline_->resumes_from()) input.skip_to(*stamp);
    const pipeline::ThreadTime reading;
    while (stop_asked == 0) {
      auto datum = input.next();
      if (!datum) break;
      pipeline_->add(std::move(*datum));
      say(input);
      progress_->show(pipeline_->progress());
    }
    reading_seconds_ = reading.seconds();
    streamed_ = progress_->seconds();
    report_ = pipeline_->finish();
    progress_->show(pipeline_->progress());
    say(input);
    progress_->end_line();
  }

  void say(pipeline::InputSource& input) {
    for (const auto& notices : {input.take_notices(), pipeline_->take_notices()}) {
      for (const std::string& notice : notices) {
        progress_->end_line();
        std::printf("%s\n", notice.c_str());
      }
    }
  }

  int conclude() {
    const double mapped = progress_->seconds();
    if (stop_asked != 0) std::printf("stopped early: what follows is the drive so far\n");
    const Session session = Session::open(options_.output, Session::Access::kRead);
    if (report_.progress.scans == 0 && session.key_frame_count() == 0) {
      throw InputError("no scan could be used, so there is no map; the lines above say why");
    }
    std::printf("%s\n", report_.optimization.message.c_str());
    double products = 0.0;
    if (!options_.no_map) {
      for (const auto& file : write_map(session, options_.map)) {
        std::printf("%s\n", file.c_str());
      }
      products = progress_->seconds() - mapped;
    }
    const double driven =
        to_seconds(std::max<Stamp>(0, std::min(end_, report_.progress.newest) - begin_));
    const auto figures = mapping_figures(report_, driven, times(mapped, products));
    std::printf("%s", to_text(figures).c_str());
    if (!options_.figures.empty()) {
      write_text_atomically(options_.figures, figures.dump(2) + "\n");
    }
    if (options_.report) run_beside("map_quality", "'" + options_.output + "' --report");
    return stop_asked != 0 ? kStoppedEarly : 0;
  }

  RunTimes times(double mapped, double map) const {
    return {reading_seconds_, streamed_, mapped, map, progress_->seconds()};
  }

  Options options_;
  StageFiles stages_;
  Stamp begin_ = 0;
  Stamp end_ = 0;
  std::unique_ptr<MappingProgress> progress_;
  std::unique_ptr<pipeline::Pipeline> pipeline_;
  pipeline::PipelineReport report_;
  double reading_seconds_ = 0.0;
  double streamed_ = 0.0;
};

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  CLI::App app{"Maps a recorded drive without a ROS master, as fast as the processor allows"};
  tools::Options options;
  tools::add_arguments(app, options);
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGINT, tools::ask_to_stop);
  std::signal(SIGTERM, tools::ask_to_stop);
  const tools::ReturnedMemory returned_memory;
  try {
    return tools::MappingRun(options).run();
  } catch (const std::exception& error) {
    std::cerr << "map_bag: " << error.what() << "\n";
    return tools::kFailed;
  }
}
