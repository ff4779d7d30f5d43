// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/preprocessor.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "lidar_mapping/common/cloud_fingerprint.hpp"
#include "lidar_mapping/common/elevation_shift.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"

#include "checks/input_diagnostics.hpp"
#include "gnss/gnss_track.hpp"
#include "motion/motion_sensors.hpp"
#include "points/thinning.hpp"
#include "scan_queue.hpp"
#include "stamp_guard.hpp"

namespace lidar_mapping::preprocessing {

void RawScan::unpack() {
  if (!packed) return;
  const unsigned char* from = packed->first;
  for (Point& point : cloud.points) {
    std::memcpy(&point, from, sizeof(Point));  // one load and store of a whole register
    std::memcpy(&point.intensity, from + packed->intensity, sizeof(float));
    from += packed->step;
  }
  packed.reset();
}

void RawScan::take_fingerprint() {
  if (fingerprint) return;
  fingerprint = packed ? cloud_fingerprint(packed->first, packed->step, cloud.size())
                       : cloud_fingerprint(cloud);
}

class Preprocessor::Impl {
 public:
  Impl(const PreprocessingConfig& config, ExtrinsicLookup lookup)
      : config_(config),
        limits_(config),
        extrinsics_(std::move(lookup)),
        sensors_(config, extrinsics_),
        gnss_(config, extrinsics_),
        progress_{0, from_seconds(config.max_latency)} {}

  void add_imu(const ImuSample& sample, const std::string& frame_id) {
    if (!config_.use_imu) return;
    const Stamp stamp = sample.stamp + from_seconds(config_.imu_time_offset);
    add_sample("imu", imu_guard_, stamp, [&] { return sensors_.add_imu(sample, frame_id); });
  }

  void add_velocity(const VelocitySample& sample, const std::string& frame_id) {
    if (!config_.use_velocity) return;
    const Stamp stamp = sample.stamp + from_seconds(config_.velocity_time_offset);
    add_sample("velocity", velocity_guard_, stamp,
               [&] { return sensors_.add_velocity(sample, frame_id); });
  }

  void add_gnss(const GnssFix& fix, const std::string& frame_id) {
    if (!config_.use_gnss) return;
    const Stamp stamp = fix.stamp + from_seconds(config_.gnss_time_offset);
    if (is_stray("gnss", gnss_guard_, stamp)) {
      ++counters_.gnss_refused;
      return;
    }
    FixResult result;
    const auto insert = [&] {
      result = gnss_.add(fix, frame_id);
      return result.insertion;
    };
    if (!insert_or_reset("gnss", stamp, insert)) reject_fix(result.problem);
  }

  void enqueue(RawScan raw) {
    ++counters_.scans_in;
    if (is_stray("points", scan_guard_, raw.stamp)) {
      ++counters_.scans_out_of_order;
      return;
    }
    if (config_.point_times == PointTimes::kAzimuth) raw.unpack();
    const auto [span, problem] =
        normalize_times(raw.cloud, raw.times_are_absolute, config_, raw.time_span);
    if (!problem.empty()) diagnostics_.warn("times", "points: " + problem);
    const Stamp stamp = raw.stamp;
    WaitingScan scan{std::move(raw), span};
    const auto insert = [&] { return queue_.insert(std::move(scan)); };
    if (insert_or_reset("points", stamp, insert)) return;
    ++counters_.scans_out_of_order;
    diagnostics_.rejected_scan(stamp);
  }

  std::vector<SyncedScan> complete_scans(Waiting waiting) {
    for (const std::string& problem : gnss_.evaluate_pending(sensors_, progress_, waiting)) {
      reject_fix(problem);
    }
    for (const Diagnostic& diagnostic : gnss_.take_diagnostics())
      diagnostics_.report(diagnostic.text, diagnostic);
    std::vector<SyncedScan> result;
    while (!queue_.empty()) {
      const bool may_wait = waiting == Waiting::kGoesOn;
      const bool leaves_early = may_wait && queue_.is_too_long();
      if (may_wait && !leaves_early && is_incomplete(queue_.oldest())) break;
      if (leaves_early) ++counters_.scans_waiting_too_long;
      if (auto synced = complete(queue_.take_oldest())) result.push_back(*std::move(synced));
    }
    return result;
  }

  std::optional<GeodeticDatum> datum() const { return gnss_.datum(); }
  const PreprocessingCounters& counters() const { return counters_; }
  std::vector<Diagnostic> take_diagnostics() { return diagnostics_.take(); }

 private:
  template <typename Insert>
  void add_sample(const std::string& input, StampGuard& guard, Stamp stamp, const Insert& insert) {
    if (is_stray(input, guard, stamp) || !insert_or_reset(input, stamp, insert)) {
      ++counters_.samples_refused;
    }
  }

  bool is_stray(const std::string& input, StampGuard& guard, Stamp stamp) {
    if (guard.accepts(stamp, progress_.newest)) return false;
    diagnostics_.stray_stamp(input, stamp - progress_.newest);
    return true;
  }

  /// Inserts the datum with this stamp; if time has gone back, everything from before is discarded
  /// first.
  template <typename Insert>
  bool insert_or_reset(const std::string& input, Stamp stamp, const Insert& insert) {
    Insertion insertion = insert();
    if (insertion == Insertion::kTimeWentBack) {
      reset(input, progress_.newest - stamp);
      insertion = insert();
    }
    if (insertion != Insertion::kInserted) return false;
    progress_.newest = std::max(progress_.newest, stamp);
    return true;
  }

  void reset(const std::string& input, Stamp jump) {
    ++counters_.resets;
    diagnostics_.time_went_back(input, jump);
    sensors_.clear();
    gnss_.clear();
    counters_.scans_discarded += queue_.size();
    queue_.clear();
    progress_.newest = last_stamp_ = 0;
  }

  void reject_fix(const std::string& problem) {
    ++counters_.gnss_refused;
    diagnostics_.rejected_fix(problem);
  }

  bool is_incomplete(const WaitingScan& scan) const {
    if (!extrinsics_.T_base(scan.raw.frame_id)) return true;
    const Stamp end = scan.raw.stamp + from_seconds(scan.span.end);
    return sensors_.imu().may_still_deliver(end, progress_) ||
           sensors_.velocity().may_still_deliver(end, progress_) ||
           gnss_.may_still_deliver(scan.raw.stamp, progress_);
  }

  std::optional<SyncedScan> complete(WaitingScan scan) {
    const auto T_base_lidar = extrinsics_.T_base(scan.raw.frame_id);
    if (!T_base_lidar) {
      ++counters_.scans_without_extrinsic;
      diagnostics_.missing_transform("points", scan.raw.frame_id);
      return std::nullopt;
    }
    sensors_.update_until(scan.raw.stamp + from_seconds(scan.span.end));
    SyncedScan result = values_at(scan.raw.stamp);
    result.frame_id = scan.raw.frame_id;
    result.T_base_lidar = *T_base_lidar;
    scan.raw.take_fingerprint();
    result.fingerprint = scan.raw.fingerprint;
    result.scan.cloud = filtered_cloud(std::move(scan), *T_base_lidar, result);
    if (result.scan.cloud.size() < static_cast<std::size_t>(config_.min_points)) {
      ++counters_.scans_without_points;
      diagnostics_.too_few_points();
      return std::nullopt;
    }
    ++counters_.scans_out;
    return result;
  }

  /// The values of the other sensors at that instant.
  SyncedScan values_at(Stamp stamp) {
    sensors_.give_up_silent_sensors();
    gnss_.give_up_if_silent();
    SyncedScan result;
    result.scan.stamp = stamp;
    sensors_.check_velocity(stamp);
    result.imu = sensors_.imu_at(stamp);
    result.velocity = sensors_.velocity_at(stamp);
    result.gnss = gnss_at(stamp, result);
    result.felt = sensors_.mean_force_between(std::exchange(last_stamp_, stamp), stamp);
    report_missing(sensors_.imu(), imu_guard_, stamp, result.imu.has_value());
    report_missing(sensors_.velocity(), velocity_guard_, stamp, result.velocity.has_value());
    report_missing(gnss_.stream(), gnss_guard_, stamp, result.gnss.has_value());
    if (sensors_.gyro_is_implausible()) diagnostics_.implausible_gyro();
    if (sensors_.acceleration_problem() != AccelerationProblem::kNone) {
      diagnostics_.rejected_acceleration(sensors_.acceleration_sentence());
    }
    if (const auto limit = sensors_.gyro_limit()) diagnostics_.clipped_gyro(*limit);
    const VelocityProblem problem = sensors_.velocity_problem(stamp);
    if (problem != VelocityProblem::kNone) {
      diagnostics_.rejected_velocity(problem, sensors_.sentence(problem));
    }
    return result;
  }

  template <typename Sample>
  void report_missing(const SensorStream<Sample>& stream, const StampGuard& guard, Stamp stamp,
                      bool is_there) {
    if (!is_there) diagnostics_.no_value(stream, guard.newest(), stamp, extrinsics_);
  }

  std::optional<GnssPosition> gnss_at(Stamp stamp, const SyncedScan& synced) {
    auto position = gnss_.at(stamp);
    if (!position || !synced.imu || !synced.imu->orientation) return position;
    const bool backwards = synced.velocity && synced.velocity->linear.x() < 0.0;
    if (gnss_.accepts_heading(*position, *synced.imu->orientation, backwards)) {
      position->R_enu_base = synced.imu->orientation;
    } else if (gnss_.heading_check().agrees().has_value()) {
      diagnostics_.rejected_heading();
    }
    return position;
  }

  PointCloud filtered_cloud(WaitingScan scan, const Pose& T_base_lidar, SyncedScan& synced) {
    PointCloud& cloud = scan.raw.cloud;
    if (config_.vertical_angle_correction != 0.0) {
      scan.raw.unpack();
      rotate_upwards(cloud, config_.vertical_angle_correction);
    }
    MeasuredMotion measured;
    if (cloud.has_times()) measured = motion_to_remove(scan, T_base_lidar, synced);
    if (!cloud.empty()) diagnostics_.motion(measured.source, cloud.has_times());
    const bool moves = measured.source != MotionSource::kNone;
    const bool compensates = moves && measured.source != MotionSource::kImu;
    counters_.points_not_finite +=
        keep_and_deskew(scan.raw.packed ? *scan.raw.packed : packed_in(cloud), cloud, T_base_lidar,
                        limits_, moves ? &measured.motion : nullptr,
                        compensates ? PointTimesAfter::kDropped : PointTimesAfter::kKept);
    if (compensates) ++counters_.scans_deskewed;
    return without_outliers(downsampled(std::move(cloud), config_), config_);
  }

  /// The motion that is removed from a cloud with times. Where the cloud keeps them, the front end
  /// estimates the motion of the LiDAR, but assumes a uniform rotation during the sweep.
  MeasuredMotion motion_to_remove(const WaitingScan& scan, const Pose& T_base_lidar,
                                  SyncedScan& synced) const {
    MeasuredMotion measured = sensors_.motion(scan.raw.stamp, scan.span, T_base_lidar.translation);
    const bool both = measured.source == MotionSource::kImuAndVelocity;
    if (config_.deskewing && (both || measured.source == MotionSource::kVelocity)) return measured;
    std::optional<Eigen::Vector3d> omega;
    if (both || measured.source == MotionSource::kImu)
      omega = mean_angular_velocity(measured.motion);
    set_rate(omega, synced);
    if (!config_.deskewing) return {};
    if (omega) {
      measured.motion = without_uniform_turning(measured.motion, *omega);
      synced.uneven_turning = turning_of(measured.motion);
    }
    return measured;
  }

  /// The rate that goes with times is the mean of their sweep: the rate at one instant is another
  /// one, above all on legs.
  static void set_rate(const std::optional<Eigen::Vector3d>& omega, SyncedScan& synced) {
    if (!synced.imu) return;
    synced.imu->has_angular_velocity = omega.has_value();
    if (omega) synced.imu->angular_velocity = *omega;
  }

  PreprocessingConfig config_;
  PassLimits limits_;
  Extrinsics extrinsics_;
  MotionSensors sensors_;
  GnssTrack gnss_;
  Progress progress_;
  StampGuard scan_guard_, imu_guard_, velocity_guard_, gnss_guard_;
  ScanQueue queue_;
  Stamp last_stamp_ = 0;  ///< of the previous scan
  PreprocessingCounters counters_;
  InputDiagnostics diagnostics_;
};

Preprocessor::Preprocessor(const PreprocessingConfig& config, ExtrinsicLookup lookup)
    : impl_(std::make_unique<Impl>(config, std::move(lookup))) {}
Preprocessor::~Preprocessor() = default;

void Preprocessor::add_imu(const ImuSample& sample, const std::string& frame_id) {
  impl_->add_imu(sample, frame_id);
}
void Preprocessor::add_velocity(const VelocitySample& sample, const std::string& frame_id) {
  impl_->add_velocity(sample, frame_id);
}
void Preprocessor::add_gnss(const GnssFix& fix, const std::string& frame_id) {
  impl_->add_gnss(fix, frame_id);
}
std::vector<SyncedScan> Preprocessor::process(RawScan scan) {
  impl_->enqueue(std::move(scan));
  return impl_->complete_scans(Waiting::kGoesOn);
}
std::vector<SyncedScan> Preprocessor::take_complete() {
  return impl_->complete_scans(Waiting::kGoesOn);
}
std::vector<SyncedScan> Preprocessor::flush() { return impl_->complete_scans(Waiting::kEnds); }
std::optional<GeodeticDatum> Preprocessor::datum() const { return impl_->datum(); }
const PreprocessingCounters& Preprocessor::counters() const { return impl_->counters(); }
std::vector<Diagnostic> Preprocessor::take_diagnostics() { return impl_->take_diagnostics(); }

}  // namespace lidar_mapping::preprocessing
