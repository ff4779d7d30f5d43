// SPDX-License-Identifier: BSD-3-Clause
// Maps a recorded drive without a ROS master, as fast as the processor allows.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <limits>
#include <thread>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"
#include "lidar_mapping/pipeline/thread_time.hpp"

#include "child_program.hpp"
#include "config_path.hpp"
#include "drive_input.hpp"
#include "map_output.hpp"
#include "mapping_figures.hpp"
#include "mapping_progress.hpp"
#include "number_checks.hpp"
#include "process_memory.hpp"
#include "run_record.hpp"
#include "session_output.hpp"
#include "stage_files.hpp"

namespace lidar_mapping::tools {

namespace {

using session::Session;

// Exit status, see doc/pipeline.md; the last is that of shells for a process that SIGINT ended.
constexpr int kFailed = 1;
constexpr int kStoppedEarly = 3;
constexpr int kDoubtful = 4;
constexpr int kStoppedAtOnce = 130;

struct Options {
  recordings::DriveSelection drive;
  std::string output;
  ParameterSources parameters;
  std::string figures;
  std::string command;    ///< as it was typed
  double start = 0.0;     ///< s of the recording that are left out
  double duration = 0.0;  ///< s that are mapped; 0: to the end
  int threads = 0;
  bool resume = false;
  bool quick_resume = false;
  bool no_map = false;
  bool report = false;
  bool allow_doubt = false;
  MapOutput map;
};

volatile std::sig_atomic_t stop_asked = 0;

extern "C" void ask_to_stop(int) {
  if (stop_asked != 0) _exit(kStoppedAtOnce);
  stop_asked = 1;
}

void add_arguments(CLI::App& app, Options& options) {
  app.add_option("input", options.drive.paths,
                 "bags of one drive, a folder of them, or a folder of scans: KITTI raw, KITTI "
                 "odometry, *.pcd or *.bin")
      ->required();
  app.add_option("-o,--output", options.output, "new folder for the session and the map")
      ->required();
  app.add_option("--config", options.parameters.config,
                 std::string(kConfigHelp) + "; defaults if left out");
  app.add_option("--sensor", options.parameters.overlay,
                 "overlay of parameters: a name in config/sensors, or the path of a file");
  app.add_option("--preset", options.parameters.preset,
                 "overlay for the kind of place: a name in config/presets, or the path of a file");
  app.add_option("--parameter", options.parameters.parameters,
                 "a single one, as 'stage/name: value' (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--points", options.drive.topics.points, "topic (found by type if left out)");
  app.add_option("--imu", options.drive.topics.imu, "topic");
  app.add_option("--velocity", options.drive.topics.velocity, "topic");
  app.add_option("--gnss", options.drive.topics.gnss, "topic");
  app.add_option("--sensor-height", options.drive.sensor_height,
                 "of folders: the LiDAR over base_link, m")
      ->capture_default_str();
  app.add_option("--start", options.start, "leave out so many seconds of the beginning")
      ->check(not_negative());
  app.add_option("--duration", options.duration, "end so many seconds after the start")
      ->check(above_zero());
  app.add_option("--threads", options.threads, "at most so many threads; 0: all cores")
      ->check(not_negative());
  app.add_flag("--resume", options.resume,
               "complete the session in the output folder: to the same bytes as without a break");
  app.add_flag("--quick-resume", options.quick_resume,
               "the same from near its end on: faster, to within centimetres");
  app.add_option("--formats", options.map.products.formats, "of the map, as build_map has them")
      ->delimiter(',')
      ->check(CLI::IsMember(map::product_formats(), CLI::ignore_case));
  app.add_option("--resolution", options.map.resolution, "edge of the map's voxels, m");
  app.add_flag("--keep-moving", options.map.keep_moving,
               "leave points of moving objects in the map");
  app.add_flag("--no-map", options.no_map, "the session alone; build_map makes a map of it later");
  app.add_flag("--report", options.report,
               "judge the map and write report.html, as map_quality does");
  app.add_flag("--allow-doubt", options.allow_doubt,
               "end with status 0 even if parts of the map cannot be trusted");
  app.add_option("--figures", options.figures, "write times and counts to this JSON file");
  app.footer(
      "exit status: 0 all is well; 1 no map, the message says why; 3 stopped early by Ctrl-C, what "
      "was mapped is whole; 4 parts of the map cannot be trusted (said at the end, and in "
      "doubt.csv), unless --allow-doubt; 130 ended at once by a second Ctrl-C");
}

Resume resume_of(const Options& options) {
  if (options.quick_resume) return Resume::kQuick;
  return options.resume ? Resume::kExact : Resume::kNo;
}

/// Tells where the part of a recording ends that is wanted. A single stamp may be astray.
class EndOfPart {
 public:
  explicit EndOfPart(Stamp end) : end_(end) {}

  /// True for what is not wanted any more.
  bool is_behind(const pipeline::Input& input) {
    const auto* scan = std::get_if<pipeline::RecordedScan>(&input);
    if (scan == nullptr) return false;
    scans_ = scan->stamp >= end_ ? scans_ + 1 : 0;
    return scans_ > 0;
  }
  bool is_over() const { return scans_ >= kCertain; }

 private:
  static constexpr int kCertain = 5;  // scans; chosen: more read further than needed
  Stamp end_;
  int scans_ = 0;  ///< in a row behind the end
};

class MappingRun {
 public:
  explicit MappingRun(const Options& options)
      : options_(options),
        stages_(read_stage_files(options.parameters)),
        output_(options.output, resume_of(options)) {
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
    recordings::OpenDrive drive =
        recordings::open_drive(options_.drive, stages_.pipeline.preprocessing);
    for (const std::string& line : drive.lines) std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    record_ = record_of(drive);
    output_.check(record_, stages_.texts);
    choose_part(*drive.input);
    progress_ = std::make_unique<MappingProgress>(begin_, end_);
    if (output_.is_resumed()) say_what_is_there();
    if (output_.is_complete()) return output_.set_map_parameters(stages_.texts.at("map"));
    try {
      map(*drive.input, false);
    } catch (const pipeline::ResumeFailure&) {
      std::printf(
          "going over the whole recording again: its last part alone does not lead to "
          "where the session ends\n");
      drive = recordings::open_drive(options_.drive, stages_.pipeline.preprocessing);
      map(*drive.input, true);
    }
    pipeline_.reset();
    record_.is_complete = stop_asked == 0 && options_.duration == 0.0 && report_.progress.scans > 0;
    if (output_.commit(record_, report_.optimization.key_frames)) return;
    std::printf("the session of %zu key frames stays as it was: this run came to %zu\n",
                output_.key_frames_before(), report_.optimization.key_frames);
  }

  report::RunRecord record_of(const recordings::OpenDrive& drive) const {
    report::RunRecord record;
    record.software = std::string("lidar_mapping ") + LIDAR_MAPPING_VERSION;
    record.command = options_.command;
    record.date = report::utc(std::time(nullptr));
    for (const std::string& path : drive.paths) record.files.push_back(report::recorded_file(path));
    record.begin = drive.input->begin();
    record.end = drive.input->end();
    record.start = options_.start;
    record.topics = drive.topics;
    record.sensor_height = drive.topics.empty() ? options_.drive.sensor_height : 0.0;
    record.sensors = drive.lines;
    return record;
  }

  /// --start and --duration.
  void choose_part(const pipeline::InputSource& input) {
    begin_ = input.begin() + from_seconds(options_.start);
    end_ = input.end();
    if (begin_ >= end_ && options_.start > 0.0) {
      throw InputError("--start " + std::to_string(options_.start) + ": the recording lasts " +
                       std::to_string(to_seconds(input.end() - input.begin())) + " s");
    }
    if (options_.duration > 0.0) end_ = std::min(end_, begin_ + from_seconds(options_.duration));
  }

  void say_what_is_there() const {
    const char* rest =
        output_.is_complete() ? "all of the recording is mapped"
        : options_.quick_resume
            ? "it is gone on with near its end"
            : "they are made again from the beginning of the recording on, to the same "
              "bytes as without a break (--quick-resume goes on near the end)";
    std::printf("%s holds %zu key frames; %s\n", options_.output.c_str(),
                output_.key_frames_before(), rest);
    std::fflush(stdout);
  }

  void map(pipeline::InputSource& input, bool whole) {
    pipeline_.reset();  // lets go of the session
    Session session = output_.open(record_);
    for (const auto& [stage, text] : stages_.texts) session.set_configuration(stage, text);
    stages_.pipeline.replay_whole = whole;
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        stages_.pipeline, std::move(session),
        [&input](const std::string& frame) { return input.T_base(frame); });
    mapped_from_ = std::max(begin_, pipeline_->resume_time().value_or(begin_));
    if (mapped_from_ > input.begin()) input.skip_to(mapped_from_);
    progress_->begin_at(mapped_from_);
    const pipeline::ThreadTime reading;
    EndOfPart part(options_.duration > 0.0 ? end_ : std::numeric_limits<Stamp>::max());
    while (stop_asked == 0 && !part.is_over()) {
      auto datum = input.next();
      if (!datum) break;
      if (part.is_behind(*datum)) continue;
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
    for (const auto& notices : {input.take_messages(), pipeline_->take_messages()}) {
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
    if (!output_.is_complete()) std::printf("%s\n", report_.optimization.message.c_str());
    double products = 0.0;
    if (!options_.no_map) {
      for (const auto& file : write_map(session, options_.map)) {
        std::printf("%s\n", file.c_str());
      }
      products = progress_->seconds() - mapped;
    }
    if (output_.is_complete()) return finish(0);
    const double driven =
        to_seconds(std::max<Stamp>(0, std::min(end_, report_.progress.newest) - mapped_from_));
    const auto figures = mapping_figures(report_, driven, times(mapped, products));
    std::printf("%s", to_text(figures).c_str());
    if (!options_.figures.empty()) {
      write_text_atomically(options_.figures, json::dumped(figures, 2) + "\n");
    }
    return finish(stop_asked != 0 ? kStoppedEarly : 0);
  }

  int finish(int status) const {
    if (options_.report) run_program(program_beside("map_quality"), {options_.output, "--report"});
    const bool is_trusted = tell_doubt();
    return status == 0 && !is_trusted && !options_.allow_doubt ? kDoubtful : status;
  }

  /// Last of all, where it is seen. Sessions of older versions have no such file.
  bool tell_doubt() const {
    const std::filesystem::path file = std::filesystem::path(options_.output) / "doubt.csv";
    if (!std::filesystem::exists(file)) return true;
    const pipeline::DriveDoubt doubt = pipeline::read_doubt(file);
    const std::string noticed = pipeline::remark(doubt);
    if (!noticed.empty()) std::printf("%s\n", noticed.c_str());
    for (const std::string& warning : pipeline::warnings(doubt)) {
      std::printf("%s\n", warning.c_str());
    }
    return doubt.is_trusted();
  }

  RunTimes times(double mapped, double map) const {
    return {reading_seconds_, streamed_, mapped, map, progress_->seconds()};
  }

  Options options_;
  StageFiles stages_;
  SessionOutput output_;
  report::RunRecord record_;
  Stamp begin_ = 0;  ///< of what is wanted of the recording
  Stamp end_ = 0;
  Stamp mapped_from_ = 0;  ///< later where a session is gone on with
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
  options.command = tools::command_line({argv, argv + argc});
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
