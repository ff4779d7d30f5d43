#include "lidar_mapping/preprocessing/preprocessor.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "lidar_mapping/preprocessing/gnss_track.hpp"
#include "lidar_mapping/preprocessing/motion_sensors.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"
#include "lidar_mapping/preprocessing/scan_times.hpp"
#include "lidar_mapping/preprocessing/thinning.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kLongestQueue = 30;          // scans
constexpr Stamp kJumpBack = from_seconds(2.0);     // the recording has begun anew
constexpr Stamp kOtherClock = from_seconds(10.0);  // no sensor is as late as that
constexpr double kPi = 3.14159265358979323846;

std::string seconds_text(Stamp interval) {
  const double tenths = std::round(to_seconds(interval) * 10.0) / 10.0;
  std::string text = std::to_string(tenths);
  return text.substr(0, text.find('.') + 2) + " s";
}

}  // namespace

class Preprocessor::Impl {
  struct WaitingScan {
    RawScan raw;
    TimeSpan span;
  };

 public:
  Impl(const PreprocessingConfig& config, ExtrinsicLookup lookup)
      : config_(config),
        limits_(config),
        extrinsics_(std::move(lookup)),
        sensors_(config, extrinsics_),
        gnss_(config, extrinsics_),
        latency_(from_seconds(config.max_latency)) {}

  void add_imu(const ImuSample& sample, const std::string& frame_id) {
    if (!config_.use_imu) return;
    const auto insert = [&] { return sensors_.add_imu(sample, frame_id); };
    count(inserted(insert, "imu"), sample.stamp);
  }

  void add_velocity(const VelocitySample& sample, const std::string& frame_id) {
    if (!config_.use_velocity) return;
    const auto insert = [&] { return sensors_.add_velocity(sample, frame_id); };
    count(inserted(insert, "velocity"), sample.stamp);
  }

  void add_gnss(const GnssFix& fix, const std::string& frame_id) {
    if (!config_.use_gnss) return;
    FixVerdict verdict;
    const auto insert = [&] {
      verdict = gnss_.add(fix, frame_id);
      return verdict.insertion;
    };
    if (inserted(insert, "gnss") == Insertion::kTaken) {
      newest_ = std::max(newest_, fix.stamp);
      return;
    }
    refuse_fix(verdict.problem);
  }

  void enqueue(RawScan scan) {
    ++counters_.scans_in;
    const Stamp newest_scan = waiting_.empty() ? last_output_ : waiting_.back().raw.stamp;
    const bool is_first = waiting_.empty() && !has_output_;
    if (!is_first && scan.stamp < newest_scan - kJumpBack) {
      begin_anew("points", newest_scan - scan.stamp);
    } else if (has_output_ && scan.stamp <= last_output_) {
      return refuse_order(scan.stamp);
    }
    const auto before = [](const WaitingScan& a, Stamp stamp) { return a.raw.stamp < stamp; };
    const auto at = std::lower_bound(waiting_.begin(), waiting_.end(), scan.stamp, before);
    if (at != waiting_.end() && at->raw.stamp == scan.stamp) return refuse_order(scan.stamp);
    const auto [span, problem] = settle_times(scan.cloud, scan.times_are_absolute, config_);
    if (!problem.empty()) notices_.warn("times", "points: " + problem);
    newest_ = std::max(newest_, scan.stamp);
    waiting_.insert(at, {std::move(scan), span});
  }

  std::vector<SyncedScan> take(bool all) {
    std::vector<SyncedScan> result;
    for (const std::string& problem : gnss_.settle(sensors_, newest_, latency_, all)) {
      refuse_fix(problem);
    }
    for (const Notice& notice : gnss_.take_notices()) notices_.say(notice.text, notice);
    while (!waiting_.empty()) {
      const bool full = waiting_.size() > kLongestQueue;
      if (!all && !full && is_incomplete(waiting_.front())) break;
      if (!all && full) ++counters_.scans_waiting_too_long;
      WaitingScan scan = std::move(waiting_.front());
      waiting_.pop_front();
      last_output_ = scan.raw.stamp;
      has_output_ = true;
      if (auto synced = completed(std::move(scan))) result.push_back(*std::move(synced));
    }
    return result;
  }

  std::optional<GeodeticDatum> datum() const { return gnss_.datum(); }
  const PreprocessingCounters& counters() const { return counters_; }
  std::vector<Notice> take_notices() { return notices_.take(); }

 private:
  /// Inserts a sample; where time has gone back, after everything before was forgotten.
  template <typename Insert>
  Insertion inserted(const Insert& insert, const std::string& name) {
    const Insertion insertion = insert();
    if (insertion != Insertion::kTimeWentBack) return insertion;
    begin_anew(name, 0);
    return insert();
  }

  void count(Insertion insertion, Stamp stamp) {
    if (insertion == Insertion::kTaken) {
      newest_ = std::max(newest_, stamp);
    } else {
      ++counters_.samples_refused;
    }
  }

  void begin_anew(const std::string& name, Stamp jump) {
    ++counters_.resets;
    const std::string by = jump > 0 ? " by " + seconds_text(jump) : "";
    notices_.forget("reset");
    notices_.warn("reset", name + ": time went back" + by +
                               "; all buffers are empty now (a recording that begins anew?)");
    sensors_.clear();
    gnss_.clear();
    counters_.scans_forgotten += waiting_.size();
    waiting_.clear();
    has_output_ = false;
    newest_ = 0;
  }

  void refuse_fix(const std::string& problem) {
    ++counters_.gnss_refused;
    notices_.warn("gnss " + problem.substr(0, 12), "gnss: fix refused: " + problem);
  }

  void refuse_order(Stamp stamp) {
    ++counters_.scans_out_of_order;
    notices_.warn("order", stamp == 0 ? "points: the stamps are 0; the driver must stamp its clouds"
                                      : "points: a scan came with the stamp of an earlier one or "
                                        "after a later one; it was dropped");
  }

  bool is_incomplete(const WaitingScan& scan) const {
    if (!extrinsics_.T_base(scan.raw.frame_id)) return true;
    const Stamp end = scan.raw.stamp + from_seconds(scan.span.end);
    return sensors_.imu().may_still_deliver(end, newest_, latency_) ||
           sensors_.velocity().may_still_deliver(end, newest_, latency_) ||
           gnss_.may_still_deliver(scan.raw.stamp, newest_, latency_);
  }

  std::optional<SyncedScan> completed(WaitingScan scan) {
    RawScan& raw = scan.raw;
    const auto T_base_lidar = extrinsics_.T_base(raw.frame_id);
    if (!T_base_lidar) {
      ++counters_.scans_without_extrinsic;
      notices_.warn("tf " + raw.frame_id, missing_transform("points", raw.frame_id));
      return std::nullopt;
    }
    sensors_.give_up_silent_sensors();
    gnss_.give_up_if_silent();
    SyncedScan result;
    result.scan.stamp = raw.stamp;
    result.imu = sensors_.imu_at(raw.stamp);
    result.velocity = sensors_.velocity_at(raw.stamp);
    result.gnss = gnss_at(raw.stamp, result);
    note_sensor(sensors_.imu(), raw.stamp, result.imu.has_value());
    note_sensor(sensors_.velocity(), raw.stamp, result.velocity.has_value());
    note_sensor(gnss_.stream(), raw.stamp, result.gnss.has_value());
    result.scan.cloud = cloud_in_base(std::move(scan), *T_base_lidar, result.imu);
    if (result.scan.cloud.size() < static_cast<std::size_t>(config_.min_points)) {
      ++counters_.scans_without_points;
      notices_.warn("empty",
                    "points: a scan had fewer than min_points points after the filters; "
                    "check distance_near_thresh, distance_far_thresh and vehicle_box");
      return std::nullopt;
    }
    ++counters_.scans_out;
    return result;
  }

  std::optional<GnssPosition> gnss_at(Stamp stamp, const SyncedScan& synced) {
    auto position = gnss_.at(stamp);
    if (!position || !synced.imu || !synced.imu->orientation) return position;
    const bool backwards = synced.velocity && synced.velocity->linear.x() < 0.0;
    if (gnss_.trusts_heading(*position, *synced.imu->orientation, backwards)) {
      position->R_enu_base = synced.imu->orientation;
    } else if (gnss_.heading_check().verdict().has_value()) {
      notices_.warn("heading",
                    "imu: its heading does not agree with the course over ground; it is "
                    "not used (set imu_orientation to ENU if it is true nevertheless)");
    }
    return position;
  }

  PointCloud cloud_in_base(WaitingScan scan, const Pose& T_base_lidar,
                           std::optional<ImuSample>& imu) {
    PointCloud cloud = std::move(scan.raw.cloud);
    if (config_.vertical_angle_correction_deg != 0.0) {
      correct_vertical_angle(cloud, config_.vertical_angle_correction_deg * kPi / 180.0);
    }
    MeasuredMotion measured;
    if (config_.deskewing && cloud.has_times()) {
      measured = sensors_.motion(scan.raw.stamp, scan.span);
    }
    note_motion(measured.source, cloud.has_times());
    if (measured.source == MotionSource::kImu) {
      // The front end knows the way of the vehicle, but takes its turning as uniform: leave it so.
      const Eigen::Vector3d omega = mean_angular_velocity(measured.motion);
      measured.motion = without_uniform_turning(measured.motion, omega);
      if (imu) {
        imu->angular_velocity = omega;
        imu->has_angular_velocity = true;
      }
    }
    const bool moves = measured.source != MotionSource::kNone;
    const bool compensates = moves && measured.source != MotionSource::kImu;
    counters_.points_not_finite +=
        move_to_base(cloud, T_base_lidar, limits_, moves ? &measured.motion : nullptr,
                     compensates ? PointTimesAfter::kDropped : PointTimesAfter::kKept);
    if (compensates) ++counters_.scans_deskewed;
    return without_outliers(downsampled(std::move(cloud), config_), config_);
  }

  void note_motion(MotionSource source, bool has_times) {
    if (!has_times) {
      notices_.inform("motion none",
                      "points: no point times; the scans are taken as compensated "
                      "(raw ones need point_times: AZIMUTH)");
    } else if (source == MotionSource::kNone) {
      notices_.inform("motion later",
                      "points: neither IMU nor velocity over the scan; the points keep "
                      "their times and the front end compensates");
    } else {
      notices_.inform(
          std::string("motion ") + to_string(source),
          std::string("points: motion during the scan compensated by ") + to_string(source));
    }
  }

  /// Says why a sensor that is there gives no value, where that is not a mere gap.
  template <typename Sample>
  void note_sensor(const SensorStream<Sample>& stream, Stamp stamp, bool has_value) {
    if (has_value || stream.buffer().empty()) return;
    if (!extrinsics_.T_base(stream.frame_id())) {
      notices_.warn("tf " + stream.name(), missing_transform(stream.name(), stream.frame_id()));
      return;
    }
    const Stamp ahead = stream.buffer().oldest().stamp - stamp;
    const Stamp behind = stamp - stream.buffer().newest().stamp;
    if (ahead > kOtherClock || behind > kOtherClock) {
      notices_.warn("clock " + stream.name(), stream.name() + ": its stamps are " +
                                                  seconds_text(std::max(ahead, behind)) +
                                                  (ahead > 0 ? " ahead of" : " behind") +
                                                  " those of the scans; is it another "
                                                  "clock? (" +
                                                  stream.name() + "_time_offset)");
    }
  }

  static std::string missing_transform(const std::string& name, const std::string& frame_id) {
    if (frame_id.empty()) return name + ": the messages name no frame; set header.frame_id";
    return name + ": no transform from '" + frame_id + "' to base_link; publish it on /tf_static";
  }

  PreprocessingConfig config_;
  PassLimits limits_;
  Extrinsics extrinsics_;
  MotionSensors sensors_;
  GnssTrack gnss_;
  Stamp latency_;
  std::deque<WaitingScan> waiting_;  ///< in the order of stamps
  Stamp newest_ = 0;                 ///< the time that the data have reached
  Stamp last_output_ = 0;
  bool has_output_ = false;
  PreprocessingCounters counters_;
  Notices notices_;
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
  return impl_->take(false);
}
std::vector<SyncedScan> Preprocessor::take_complete() { return impl_->take(false); }
std::vector<SyncedScan> Preprocessor::flush() { return impl_->take(true); }
std::optional<GeodeticDatum> Preprocessor::datum() const { return impl_->datum(); }
const PreprocessingCounters& Preprocessor::counters() const { return impl_->counters(); }
std::vector<Notice> Preprocessor::take_notices() { return impl_->take_notices(); }

}  // namespace lidar_mapping::preprocessing
