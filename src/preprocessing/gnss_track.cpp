#include "lidar_mapping/preprocessing/gnss_track.hpp"

#include <algorithm>
#include <cmath>

namespace lidar_mapping::preprocessing {

namespace {

constexpr Stamp kJumpBack = from_seconds(2.0);
constexpr std::size_t kMostPending = 200;
constexpr double kLongestMotion = 10.0;  // s; dead reckoning beyond says little

}  // namespace

GnssTrack::GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics)
    : config_(config),
      extrinsics_(extrinsics),
      local_frame_(config),
      stream_("gnss", config.use_gnss, config.gnss_max_gap) {}

FixVerdict GnssTrack::add(GnssFix fix, const std::string& frame_id) {
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) return {Insertion::kRefused, problem};
  fix.stamp += from_seconds(config_.gnss_time_offset);
  const Stamp newest = pending_.empty() ? last_judged_ : pending_.back().stamp;
  if (newest != 0 && fix.stamp < newest - kJumpBack) return {Insertion::kTimeWentBack, ""};
  const auto is_before = [](const LocalFix& a, Stamp stamp) { return a.stamp < stamp; };
  const auto at = std::lower_bound(pending_.begin(), pending_.end(), fix.stamp, is_before);
  if (fix.stamp <= last_judged_ || (at != pending_.end() && at->stamp == fix.stamp)) {
    return {Insertion::kRefused, "it repeats the time of a fix or is older than a later one"};
  }
  frame_id_ = frame_id;
  pending_.insert(at, local_frame_.to_local(fix));
  if (pending_.size() > kMostPending) pending_.pop_front();
  return {Insertion::kTaken, ""};
}

std::vector<std::string> GnssTrack::settle(const MotionSensors& sensors, Stamp now, Stamp latency,
                                           bool all) {
  std::vector<std::string> refused;
  while (!pending_.empty()) {
    const LocalFix fix = pending_.front();
    const bool waits = sensors.velocity().may_still_deliver(fix.stamp, now, latency) ||
                       sensors.imu().may_still_deliver(fix.stamp, now, latency);
    if (waits && !all) break;
    pending_.pop_front();
    const std::string problem = config_.gnss_gating ? judge(fix, sensors) : "";
    last_judged_ = fix.stamp;
    if (problem.empty()) {
      stream_.insert(fix, frame_id_);
    } else {
      refused.push_back(problem);
    }
  }
  return refused;
}

std::string GnssTrack::judge(const LocalFix& fix, const MotionSensors& sensors) {
  std::optional<Pose> motion;
  const double seconds = to_seconds(fix.stamp - last_judged_);
  if (last_judged_ != 0 && seconds < kLongestMotion) {
    const MeasuredMotion measured = sensors.motion(last_judged_, {0.0, seconds});
    const bool drives = measured.source == MotionSource::kImuAndVelocity ||
                        measured.source == MotionSource::kVelocity;
    if (drives) motion = measured.motion.at(seconds);
  }
  const auto T_base_antenna = extrinsics_.T_base(frame_id_);
  const Eigen::Vector3d lever =
      T_base_antenna ? T_base_antenna->translation : Eigen::Vector3d::Zero();
  return gate_.judge(fix, lever, motion);
}

bool GnssTrack::may_still_deliver(Stamp stamp, Stamp now, Stamp latency) const {
  if (!pending_.empty() && pending_.back().stamp >= stamp) return now < stamp + latency;
  return stream_.may_still_deliver(stamp, now, latency);
}

std::optional<GnssPosition> GnssTrack::at(Stamp stamp) const {
  const auto pair = stream_.around(stamp);
  if (!pair) return std::nullopt;
  const auto T_base_antenna = extrinsics_.T_base(stream_.frame_id());
  if (!T_base_antenna) return std::nullopt;
  const LocalFix fix = interpolated(*pair->first, *pair->second, stamp);
  GnssPosition position;
  position.stamp = stamp;
  position.p_enu_antenna = fix.p_enu;
  position.covariance = fix.covariance;
  position.p_base_antenna = T_base_antenna->translation;
  return position;
}

bool GnssTrack::trusts_heading(const GnssPosition& position, const Eigen::Quaterniond& R_enu_base,
                               bool backwards) {
  if (config_.imu_orientation != ImuOrientation::kAuto) {
    return config_.imu_orientation == ImuOrientation::kEnu;
  }
  const Eigen::Vector3d p_enu_base = position.p_enu_antenna - R_enu_base * position.p_base_antenna;
  const double sigma = std::sqrt(position.covariance.diagonal().head<2>().maxCoeff());
  heading_check_.add(p_enu_base, sigma, R_enu_base, backwards);
  return heading_check_.verdict().value_or(false);
}

void GnssTrack::clear() {
  stream_.clear();
  pending_.clear();
  last_judged_ = 0;
  gate_.clear();
  heading_check_ = {};
}

}  // namespace lidar_mapping::preprocessing
