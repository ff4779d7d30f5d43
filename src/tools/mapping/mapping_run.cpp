// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapping_run.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <utility>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/thread_time.hpp"
#include "lidar_mapping/loop_closing/method_substitution.hpp"
#include "lidar_mapping/pipeline/drive_doubt.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"

#include "command_line/child_program.hpp"
#include "mapping/mapping_figures.hpp"
#include "mapping/mapping_progress.hpp"
#include "mapping/session_output.hpp"
#include "recording/recording_part.hpp"
#include "run_record.hpp"

namespace lidar_mapping::tools {

namespace {

using session::Session;

// Exit status, chosen different from those of shells, see doc/pipeline.md.
constexpr int kStoppedEarly = 3;
constexpr int kDoubtful = 4;

Resume resume_of(const MappingOptions& options) {
  if (options.quick_resume) return Resume::kQuick;
  return options.resume ? Resume::kExact : Resume::kNo;
}

class MappingRun {
 public:
  MappingRun(const MappingOptions& options, const volatile std::sig_atomic_t& stop_requested)
      : options_(options),
        stop_requested_(stop_requested),
        stages_(read_stages(options_)),
        output_(options.output, resume_of(options)) {
    options_.map.threads = options.threads;
    check_numbers(options_.map);
  }

  int run() {
    print_methods();
    map_recording();
    return conclude();
  }

 private:
  /// Says which method does the work of one that another system has.
  void print_methods() const {
    const std::string odometry =
        registration::describe_substitution(stages_.pipeline.front_end.registration);
    const std::string loops =
        loop_closing::describe_substitution(stages_.pipeline.loop_closing.registration_method);
    if (!odometry.empty()) std::printf("odometry: %s\n", odometry.c_str());
    if (!loops.empty()) std::printf("loops: %s\n", loops.c_str());
  }

  /// Releases the recording's index and the pipeline at the end, because the map needs their
  /// memory.
  void map_recording() {
    recordings::OpenDrive drive =
        recordings::open_drive(options_.drive, stages_.pipeline.preprocessing);
    for (const std::string& line : drive.lines) std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    record_ = record_of(drive);
    output_.check(record_, stages_.texts);
    part_ = chosen_part(*drive.input, options_.start, options_.duration);
    progress_ = std::make_unique<MappingProgress>(part_.begin, part_.end);
    if (output_.is_resumed()) print_resume_state();
    if (output_.is_complete()) return output_.set_map_parameters(stages_.texts.at("map"));
    try {
      map(*drive.input, false);
    } catch (const pipeline::ResumeFailure&) {
      std::printf(
          "the whole recording is mapped again, because its last part alone does not lead to the "
          "end of the session\n");
      drive = recordings::open_drive(options_.drive, stages_.pipeline.preprocessing);
      map(*drive.input, true);
    }
    pipeline_.reset();
    record_.is_complete =
        stop_requested_ == 0 && options_.duration == 0.0 && report_.progress.scans > 0;
    if (output_.commit(record_, report_.optimization.key_frames)) return;
    std::printf("the session with %zu key frames is not changed, because this run made only %zu\n",
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

  void print_resume_state() const {
    const char* rest =
        output_.is_complete() ? "all of the recording is mapped"
        : options_.quick_resume
            ? "it is continued near its end"
            : "they are mapped again from the beginning of the recording on, to the same "
              "bytes as without a break (--quick-resume continues near the end)";
    std::printf("%s holds %zu key frames; %s\n", options_.output.c_str(),
                output_.key_frames_before(), rest);
    std::fflush(stdout);
  }

  void map(pipeline::InputSource& input, bool from_beginning) {
    pipeline_.reset();  // closes the session
    Session session = output_.open(record_);
    for (const auto& [stage, text] : stages_.texts) session.set_configuration(stage, text);
    stages_.pipeline.replay_whole = from_beginning;
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        stages_.pipeline, std::move(session),
        [&input](const std::string& frame) { return input.T_base(frame); });
    mapped_from_ = std::max(part_.begin, pipeline_->resume_time().value_or(part_.begin));
    if (mapped_from_ > input.begin()) input.skip_to(mapped_from_);
    progress_->begin_at(mapped_from_);
    const ThreadTime reading;
    read_until(part_.limit, stop_requested_, input, [&](pipeline::Input&& datum) {
      pipeline_->add(std::move(datum));
      print_messages(input);
      progress_->show(pipeline_->progress());
    });
    reading_seconds_ = reading.seconds();
    stream_seconds_ = progress_->seconds();
    report_ = pipeline_->finish();
    progress_->show(pipeline_->progress());
    print_messages(input);
    progress_->end_line();
  }

  void print_messages(pipeline::InputSource& input) {
    for (const auto& messages : {input.take_messages(), pipeline_->take_messages()}) {
      for (const std::string& message : messages) {
        progress_->end_line();
        std::printf("%s\n", message.c_str());
      }
    }
  }

  int conclude() {
    const double mapped = progress_->seconds();
    if (stop_requested_ != 0)
      std::printf("stopped early: the following results are those of the drive so far\n");
    const Session session = Session::open(options_.output, Session::Access::kRead);
    if (session.key_frame_count() == 0) throw InputError(why_no_map(report_.progress.scans));
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
        to_seconds(std::max<Stamp>(0, std::min(part_.end, report_.progress.newest) - mapped_from_));
    const auto figures = mapping_figures(report_, driven, times(mapped, products));
    std::printf("%s", to_text(figures).c_str());
    if (!options_.figures.empty()) {
      write_text_atomically(options_.figures, json::dumped(figures, 2) + "\n");
    }
    return finish(stop_requested_ != 0 ? kStoppedEarly : 0);
  }

  static std::string why_no_map(std::size_t scans) {
    const std::string none = scans == 0
                                 ? "no scan could be used"
                                 : "none of " + std::to_string(scans) + " scans could start a map";
    return none + ", so there is no map; the lines above say why";
  }

  int finish(int status) const {
    if (options_.report) run_program(program_beside("map_quality"), {options_.output, "--report"});
    const bool is_trusted = print_doubt();
    return status == 0 && !is_trusted && !options_.allow_doubt ? kDoubtful : status;
  }

  /// Prints the warnings about doubtful sections, at the very end of the output where they are
  /// noticed. Sessions of older versions have no such file.
  bool print_doubt() const {
    const std::filesystem::path file = std::filesystem::path(options_.output) / "doubt.csv";
    if (!std::filesystem::exists(file)) return true;
    const pipeline::DriveDoubt doubt = pipeline::read_doubt(file);
    const std::string remark = pipeline::remark(doubt);
    if (!remark.empty()) std::printf("%s\n", remark.c_str());
    for (const std::string& warning : pipeline::warnings(doubt)) {
      std::printf("%s\n", warning.c_str());
    }
    return doubt.is_trusted();
  }

  RunTimes times(double mapped, double map) const {
    return {reading_seconds_, stream_seconds_, mapped, map, progress_->seconds()};
  }

  MappingOptions options_;
  const volatile std::sig_atomic_t& stop_requested_;
  StageFiles stages_;
  SessionOutput output_;
  report::RunRecord record_;
  RecordingPart part_;     ///< that is mapped
  Stamp mapped_from_ = 0;  ///< later if a session is resumed
  std::unique_ptr<MappingProgress> progress_;
  std::unique_ptr<pipeline::Pipeline> pipeline_;
  pipeline::PipelineReport report_;
  double reading_seconds_ = 0.0;
  double stream_seconds_ = 0.0;
};

}  // namespace

int map_recording(const MappingOptions& options, const volatile std::sig_atomic_t& stop_requested) {
  return MappingRun(options, stop_requested).run();
}

}  // namespace lidar_mapping::tools
