#include "lidar_mapping/preprocessing/gnss_track.hpp"

#include <cmath>

namespace lidar_mapping::preprocessing {

GnssTrack::GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics)
    : config_(config),
      extrinsics_(extrinsics),
      local_frame_(config),
      stream_("gnss", config.use_gnss, config.gnss_max_gap) {}

FixVerdict GnssTrack::add(GnssFix fix, const std::string& frame_id) {
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) return {Insertion::kRefused, problem};
  fix.stamp += from_seconds(config_.gnss_time_offset);
  const Insertion insertion = stream_.insert(local_frame_.to_local(fix), frame_id);
  return {insertion, insertion == Insertion::kRefused ? "a fix of the same time came before" : ""};
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
  heading_check_ = {};
}

}  // namespace lidar_mapping::preprocessing
