// SPDX-License-Identifier: BSD-3-Clause
#include "gnss/gnss_track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

namespace {

constexpr std::size_t kMaxPending = 200;  // fixes that wait for the motion, 20 s at 10 Hz; chosen
// s of dead reckoning between two scans; after that it is too inaccurate to judge a fix (0.1 m/s of
// an error of the speed are 1 m). Chosen.
constexpr double kMaxDeadReckoning = 10.0;
// m from the first fix; a smaller error is corrected during the drive. Chosen, far beyond the
// errors of receivers.
constexpr double kMinDistanceOfOtherStart = 1000.0;
// m between two fixes that confirm each other against the first: the scatter of receivers without
// corrections, and far below kMinDistanceOfOtherStart. Chosen.
constexpr double kMaxDistanceOfAgreement = 20.0;
// s; smaller changes of the correction are not applied. Chosen: at 70 m/s they are 7 cm.
constexpr double kMinDelayChange = 0.001;

/// Metres with two decimals.
std::string metres(double value) { return formatted("%.2f m", std::round(value * 100.0) / 100.0); }

}  // namespace

GnssTrack::GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics)
    : config_(config),
      extrinsics_(extrinsics),
      local_frame_(config),
      stream_("gnss", config.use_gnss, config.gnss_max_gap) {}

FixResult GnssTrack::add(GnssFix fix, const std::string& frame_id) {
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) return {Insertion::kRefused, problem};
  fix.stamp += from_seconds(config_.gnss_time_offset - delay_);
  const Stamp newest = pending_fixes_.empty() ? last_checked_ : pending_fixes_.back().fix.stamp;
  if (newest != 0 && fix.stamp < newest - kJumpBack) return {Insertion::kTimeWentBack, ""};
  const auto is_before = [](const PendingFix& a, Stamp stamp) { return a.fix.stamp < stamp; };
  const auto at =
      std::lower_bound(pending_fixes_.begin(), pending_fixes_.end(), fix.stamp, is_before);
  if (fix.stamp <= last_checked_ || (at != pending_fixes_.end() && at->fix.stamp == fix.stamp)) {
    return {Insertion::kRefused, "it repeats the time of a fix or is older than a later one"};
  }
  frame_id_ = frame_id;
  LocalFix local = local_frame_.to_local(fix);
  if (!has_height(local.covariance)) {
    diagnostics_.warn(
        "height",
        "gnss: fixes come without altitude; they are used east and north. The map is "
        "at the height of the datum, " +
            metres(local_frame_.datum()->altitude_m) +
            " above the ellipsoid; set use_datum and datum if a better height is known");
  }
  scatter_.add(local);
  const double factor = scatter_.variance_factor();
  local.covariance *= factor;
  if (factor > 1.0 && scatter_.is_known()) {
    diagnostics_.warn("scatter", "gnss: fixes scatter by " + metres(scatter_.measured()) +
                                     ", but their covariance gives " + metres(scatter_.stated()) +
                                     "; the covariance is raised to the measured scatter");
  }
  pending_fixes_.insert(at, {fix, local, delay_});
  if (pending_fixes_.size() > kMaxPending) {
    pending_fixes_.pop_front();
    ++dropped_;
  }
  return {Insertion::kInserted, ""};
}

std::vector<std::string> GnssTrack::evaluate_pending(MotionSensors& sensors,
                                                     const Progress& progress, Waiting waiting) {
  std::vector<std::string> rejected(std::exchange(dropped_, std::size_t{0}),
                                    "IMU and velocity did not reach its stamp before " +
                                        std::to_string(kMaxPending) + " later fixes came");
  while (!pending_fixes_.empty()) {
    PendingFix pending = pending_fixes_.front();
    LocalFix& fix = pending.fix;
    const bool lacks_motion = sensors.velocity().may_still_deliver(fix.stamp, progress) ||
                              sensors.imu().may_still_deliver(fix.stamp, progress);
    if (lacks_motion && waiting == Waiting::kGoesOn) break;
    pending_fixes_.pop_front();
    sensors.update_until(fix.stamp);
    sensors.check_velocity(fix);
    const std::string problem = check(pending, sensors);
    if (!problem.empty() && config_.gnss_gating) {
      if (confirms_other_start(pending)) {
        restart_from(*last_rejected_, pending, sensors);
        continue;
      }
      last_checked_ = fix.stamp;
      last_rejected_ = pending;
      rejected.push_back(problem);
      continue;
    }
    last_checked_ = fix.stamp;
    if (problem.empty()) update_antenna_fit(pending, sensors);
    accept(pending);
  }
  return rejected;
}

void GnssTrack::accept(PendingFix pending) {
  accepted_count_ = std::min<std::size_t>(accepted_count_ + 1, 2);
  pending.fix.stamp += from_seconds(pending.applied_delay);
  stream_.insert(pending.fix, frame_id_);
}

/// True if this fix and the previous one, both rejected, show that the first fix was wrong.
bool GnssTrack::confirms_other_start(const PendingFix& pending) const {
  if (accepted_count_ != 1 || !last_rejected_ || stream_.buffer().empty()) return false;
  const double off = step_between(stream_.buffer().newest(), pending.fix).norm();
  const double seconds = to_seconds(pending.fix.stamp - last_rejected_->fix.stamp);
  const double step = step_between(last_rejected_->fix, pending.fix).norm();
  return off > kMinDistanceOfOtherStart && step < kMaxDistanceOfAgreement + kMaxRoadSpeed * seconds;
}

/// Discards everything that came from the first fix; the frame begins again.
void GnssTrack::restart_from(PendingFix first, PendingFix& second, const MotionSensors& sensors) {
  const double off = step_between(stream_.buffer().newest(), first.fix).norm();
  diagnostics_.warn("start",
                    "gnss: the first fix is " + std::to_string(std::lround(off / 1e3)) +
                        " km from the next ones, which agree; it is left out and the drive "
                        "begins with these");
  local_frame_.begin_at(first.original);
  stream_.clear();
  gate_ = {};
  scatter_ = {};
  antenna_fit_.begin_window();
  last_rejected_.reset();
  accepted_count_ = 0;
  const auto convert_to_local = [this](PendingFix& pending) {
    pending.fix.p_enu = local_frame_.to_local(pending.original).p_enu;
    scatter_.add(pending.fix);
  };
  convert_to_local(first);
  convert_to_local(second);
  for (PendingFix& pending : pending_fixes_) convert_to_local(pending);
  gate_.check(first.fix, lever_arm(), std::nullopt);
  accept(first);
  last_checked_ = first.fix.stamp;
  if (check(second, sensors).empty()) accept(second);
  last_checked_ = second.fix.stamp;
}

std::optional<GeodeticDatum> GnssTrack::datum() const {
  const bool is_sure = config_.use_datum || !config_.gnss_gating || accepted_count_ > 1;
  return is_sure ? local_frame_.datum() : std::nullopt;
}

std::string GnssTrack::check(const PendingFix& pending, const MotionSensors& sensors) {
  return gate_.check(pending.fix, lever_arm(), motion_since_last_fix(pending.fix.stamp, sensors));
}

/// T_previous_now of base_link since the fix before.
std::optional<Pose> GnssTrack::motion_since_last_fix(Stamp stamp,
                                                     const MotionSensors& sensors) const {
  const double seconds = to_seconds(stamp - last_checked_);
  if (last_checked_ == 0 || seconds >= kMaxDeadReckoning) return std::nullopt;
  const MeasuredMotion measured =
      sensors.motion(last_checked_, {0.0, seconds}, Eigen::Vector3d::Zero());
  const bool drives = measured.source == MotionSource::kImuAndVelocity ||
                      measured.source == MotionSource::kVelocity;
  if (!drives) return std::nullopt;
  return measured.motion.at(seconds);
}

Eigen::Vector3d GnssTrack::lever_arm() const {
  const auto T_base_antenna = extrinsics_.T_base(frame_id_);
  return T_base_antenna ? T_base_antenna->translation : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

/// In the axes of dead reckoning (dr, see TrackedFix); empty if dead reckoning has no pose at this
/// fix.
std::optional<Eigen::Vector3d> GnssTrack::antenna_velocity(Stamp stamp,
                                                           const MotionSensors& sensors) const {
  const auto T_dr_base = gate_.dead_reckoning();
  const auto velocity = sensors.velocity_at(stamp);
  if (!T_dr_base || !velocity) return std::nullopt;
  return T_dr_base->rotation *
         Eigen::Vector3d(velocity->linear + velocity->angular.cross(lever_arm()));
}

void GnssTrack::update_antenna_fit(const PendingFix& pending, const MotionSensors& sensors) {
  const auto v_dr = antenna_velocity(pending.fix.stamp, sensors);
  if (!v_dr) return antenna_fit_.begin_window();
  const Pose T_dr_base = *gate_.dead_reckoning();
  const Eigen::Vector3d ahead = T_dr_base.rotation * Eigen::Vector3d::UnitX();
  TrackedFix tracked;
  tracked.stamp = pending.fix.stamp;
  tracked.p_enu = pending.fix.p_enu.head<2>();
  tracked.yaw_dr = std::atan2(ahead.y(), ahead.x());
  tracked.p_dr_base = T_dr_base.translation.head<2>();
  tracked.v_dr = v_dr->head<2>();
  tracked.p_base_antenna = lever_arm().head<2>();
  tracked.applied_delay = pending.applied_delay;
  antenna_fit_.add(tracked);
  update_delay();
}

void GnssTrack::update_delay() {
  const AntennaFit::Result fit = antenna_fit_.result();
  if (!fit.delay_is_known() || (!fit.is_late() && delay_ == 0.0)) return;
  if (std::abs(fit.delay - delay_) < kMinDelayChange) return;
  delay_ = fit.delay;
  diagnostics_.warn(
      "delay",
      "gnss: its stamps are " + formatted("%.0f ms", std::round(1e3 * std::abs(delay_))) +
          (delay_ > 0.0 ? " late" : " early") +
          " compared with IMU and velocity; this is only used to check the fixes, and positions "
          "keep their stamps. The back end estimates the offset relative to odometry and corrects "
          "it (estimate_gnss_time_offset); to correct it here, set gnss_time_offset to " +
          formatted("%.3f", config_.gnss_time_offset - delay_));
}

bool GnssTrack::may_still_deliver(Stamp stamp, const Progress& progress) const {
  // That of the position, which keeps what was taken off for the check.
  const auto kept_stamp = [](const PendingFix& pending) {
    return pending.fix.stamp + from_seconds(pending.applied_delay);
  };
  if (!pending_fixes_.empty() && kept_stamp(pending_fixes_.back()) >= stamp)
    return progress.newest < stamp + progress.latency;
  return stream_.may_still_deliver(stamp, progress);
}

std::optional<GnssPosition> GnssTrack::at(Stamp stamp) const {
  const auto pair = stream_.around(stamp);
  if (!pair) return std::nullopt;
  const auto T_base_antenna = extrinsics_.T_base(stream_.frame_id());
  if (!T_base_antenna) return std::nullopt;
  const LocalFix* earlier = stream_.before(pair->first->stamp);
  const LocalFix fix = earlier ? interpolated(*earlier, *pair->first, *pair->second, stamp)
                               : interpolated(*pair->first, *pair->second, stamp);
  GnssPosition position;
  position.stamp = stamp;
  position.p_enu_antenna = fix.p_enu;
  position.covariance = fix.covariance;
  position.p_base_antenna = T_base_antenna->translation;
  return position;
}

bool GnssTrack::accepts_heading(const GnssPosition& position, const Eigen::Quaterniond& R_enu_base,
                                bool backwards) {
  if (config_.imu_orientation != ImuOrientation::kAuto) {
    return config_.imu_orientation == ImuOrientation::kEnu;
  }
  heading_check_.add(position.p_enu_base(R_enu_base), horizontal_sigma(position.covariance),
                     R_enu_base, backwards);
  return heading_check_.agrees().value_or(false);
}

void GnssTrack::clear() {
  stream_.clear();
  pending_fixes_.clear();
  last_rejected_.reset();
  last_checked_ = 0;
  gate_ = {};
  scatter_ = {};
  antenna_fit_.begin_window();
  heading_check_ = {};
}

}  // namespace lidar_mapping::preprocessing
