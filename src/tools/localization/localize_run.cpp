// SPDX-License-Identifier: BSD-3-Clause
#include "localization/localize_run.hpp"

#include <cstdio>
#include <optional>
#include <utility>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/thread_time.hpp"
#include "lidar_mapping/pipeline/map_extender.hpp"
#include "lidar_mapping/pipeline/recorded_odometry.hpp"
#include "lidar_mapping/pipeline/relative_odometry.hpp"
#include "lidar_mapping/pipeline/scan_record.hpp"
#include "lidar_mapping/pipeline/session_map.hpp"

#include "localization/localize_files.hpp"
#include "localization/localize_summary.hpp"
#include "localization_record.hpp"
#include "recording/recording_part.hpp"

namespace lidar_mapping::tools {

namespace {

// Exit status, see doc/localization.md; chosen as those of map_bag, and one of its own.
constexpr int kStoppedEarly = 3;
constexpr int kNeverFound = 5;

std::optional<Pose> initial_pose_of(const LocalizingOptions& options) {
  if (options.initial_pose.empty()) return std::nullopt;
  return pose_from_degrees(options.initial_pose);
}

/// Localises scans one after the other.
class LocalizedDrive {
 public:
  /// `extender` takes the scans, too, unless it is null.
  LocalizedDrive(localization::MapIndex& map, const std::optional<Pose>& initial_pose,
                 pipeline::MapExtender* extender)
      : localizer_(map), extender_(extender) {
    if (initial_pose) localizer_.set_initial_pose(*initial_pose);
  }

  void add(pipeline::OdometryScan&& scan) {
    const ThreadTime time;
    const localization::LocalizerInput input = input_of(scan);
    path_ += input.T_previous_base.translation.norm();
    LocalizedScan localized{localizer_.process(input), scan.result.T_odom_base, scan.result.segment,
                            path_, 0.0};
    localized.seconds = time.seconds();
    if (extender_ != nullptr) extend(scan.result, localized.result);
    scans_.push_back(std::move(localized));
  }

  const std::vector<LocalizedScan>& scans() const { return scans_; }

 private:
  void extend(const front_end::FrontEndResult& odometry,
              const localization::LocalizationResult& place) {
    extender_->add_scan(pipeline::record_of(odometry));
    extender_->add_odometry(odometry.stamp, odometry.T_odom_base);
    if (odometry.key_frame) extender_->add_key_frame(*odometry.key_frame, place);
  }

  /// Takes the points of the scan.
  localization::LocalizerInput input_of(pipeline::OdometryScan& scan) {
    pipeline::OdometryStep step{scan.result.stamp, scan.result.T_odom_base, {}};
    if (segment_ == scan.result.segment) step.covariance = scan.result.covariance;
    segment_ = scan.result.segment;
    motion_.add(step);
    localization::LocalizerInput input = motion_.input_of(std::move(scan.scan));
    input.p_base_lidar = scan.p_base_lidar;
    return input;
  }

  localization::Localizer localizer_;
  pipeline::MapExtender* extender_;
  pipeline::RelativeOdometry motion_;
  std::optional<std::uint32_t> segment_;  ///< of the newest scan
  std::vector<LocalizedScan> scans_;
  double path_ = 0.0;
};

void print(const std::vector<std::string>& messages) {
  for (const std::string& message : messages) std::printf("%s\n", message.c_str());
  std::fflush(stdout);
}

class LocalizingRun {
 public:
  LocalizingRun(const LocalizingOptions& options, const volatile std::sig_atomic_t& stop_requested)
      : options_(options), stop_requested_(stop_requested), stages_(read_stages(options_)) {
    check_new_folder(options.output);
    if (!options.extend.empty()) check_session_folder(options.extend, options.output);
  }

  int run() {
    recordings::OpenDrive drive =
        recordings::open_drive(options_.drive, stages_.pipeline.preprocessing);
    print(drive.lines);
    const RecordingPart part = chosen_part(*drive.input, options_.start, options_.duration);
    pipeline::SessionMap map(options_.map, stages_.pipeline.loop_closing, stages_.pipeline.threads);
    print({"map: " + map.size_text()});
    if (!options_.extend.empty()) {
      extender_.emplace(options_.map, pipeline::folder_beside(options_.extend));
    }
    LocalizedDrive localized(map.index(), initial_pose_of(options_),
                             extender_ ? &*extender_ : nullptr);
    read(*drive.input, part, localized);
    if (localized.scans().empty() && stop_requested_ != 0) {
      print({"stopped before the first scan was localised: there are no results"});
      return kStoppedEarly;
    }
    if (localized.scans().empty()) {
      throw InputError("no scan could be used; the lines above say why");
    }
    write_localization(options_.output, localized.scans(), map.datum());
    report::write_localization_record(options_.output,
                                      {report::names_of_recordings(drive.paths),
                                       report::identity_of(map.poses(), map.directory())});
    return conclude(localized.scans());
  }

 private:
  void read(pipeline::InputSource& input, const RecordingPart& part, LocalizedDrive& localized) {
    pipeline::RecordedOdometry odometry(
        stages_.pipeline, [&input](const std::string& frame) { return input.T_base(frame); },
        [&localized](pipeline::OdometryScan&& scan) { localized.add(std::move(scan)); });
    if (part.begin > input.begin()) input.skip_to(part.begin);
    read_until(part.limit, stop_requested_, input, [&](pipeline::Input&& datum) {
      odometry.add(std::move(datum));
      print(input.take_messages());
      print(odometry.take_messages());
    });
    odometry.finish();
    print(odometry.take_messages());
  }

  int conclude(const std::vector<LocalizedScan>& scans) {
    const json::Json figures = localization_figures(scans);
    if (stop_requested_ != 0)
      std::printf("stopped early: the following results are those of the drive so far\n");
    std::printf("%s", localization_text(figures).c_str());
    std::printf("%s\n%s\n", (options_.output + "/trajectory/localized.tum").c_str(),
                (options_.output + "/localization.csv").c_str());
    if (!options_.figures.empty()) {
      write_text_atomically(options_.figures, json::dumped(figures, 2) + "\n");
    }
    std::fflush(stdout);
    if (extender_) print_extension();
    if (figures["found_after"].is_null()) return report_never_found(scans.back());
    return stop_requested_ != 0 ? kStoppedEarly : 0;
  }

  void print_extension() const {
    const pipeline::ExtensionReport report = extender_->write(extender_->drive(), options_.extend);
    std::printf("%s", extension_text(report, options_.extend).c_str());
  }

  int report_never_found(const LocalizedScan& last) const {
    std::fprintf(stderr,
                 "localize_bag: the drive was never found in the map %s (%s); give --initial-pose "
                 "if you know where it begins\n",
                 options_.map.c_str(), last.result.reason.c_str());
    return kNeverFound;
  }

  LocalizingOptions options_;
  const volatile std::sig_atomic_t& stop_requested_;
  StageFiles stages_;
  std::optional<pipeline::MapExtender> extender_;  ///< with --extend
};

}  // namespace

int localize_recording(const LocalizingOptions& options,
                       const volatile std::sig_atomic_t& stop_requested) {
  return LocalizingRun(options, stop_requested).run();
}

}  // namespace lidar_mapping::tools
