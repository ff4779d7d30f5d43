// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "lidar_mapping/back_end/relative_covariance.hpp"

namespace lidar_mapping::pipeline {

namespace {

using back_end::RelativeCovariance;

/// Key frames within a stretch at which the error is looked at.
constexpr std::size_t kLooks = 8;

TrackingSummary summary_of(const std::vector<session::ScanRecord>& scans,
                           const std::vector<std::pair<Stamp, Pose>>& odometry) {
  std::map<Stamp, Eigen::Vector3d> places;
  for (const auto& [stamp, T_odom_base] : odometry) places[stamp] = T_odom_base.translation;
  TrackingSummary summary;
  for (const session::ScanRecord& scan : scans) {
    const auto place = places.find(scan.stamp);
    if (place == places.end()) continue;
    summary.add({scan.stamp, doubt_of_state(scan.state), place->second, scan.unobserved_stddev,
                 scan.probability});
  }
  return summary;
}

/// Judges stretches by the key frames and the graph.
class Judge {
 public:
  Judge(const session::Session& session, const std::vector<session::ScanRecord>& scans,
        const back_end::BackEnd& back_end, const KeyFramePoses& poses)
      : key_frames_(session.key_frames()), back_end_(back_end) {
    for (const session::ScanRecord& scan : scans) {
      variances_[scan.stamp] = scan.unobserved_stddev * scan.unobserved_stddev;
    }
    for (const KeyFramePose& pose : poses.poses) T_map_base_[pose.index] = pose.T_map_base;
  }

  void judge(std::vector<DoubtfulStretch>& stretches) {
    for (DoubtfulStretch& stretch : stretches) {
      if (stretch.doubt == Doubt::kDegenerate) {
        weigh(stretch);
      } else {
        stretch.expected_error = claimed_error(stretch);
        if (stretch.doubt != Doubt::kLost) weigh_claim(stretch);
      }
    }
    find_gaps(stretches);
    for (DoubtfulStretch& stretch : stretches) stretch.place = in_map(stretch);
  }

 private:
  /// Position of the first key frame at or behind a stamp; the number of all if there is none.
  std::size_t first_from(Stamp stamp) const {
    const auto found =
        std::lower_bound(key_frames_.begin(), key_frames_.end(), stamp,
                         [](const KeyFrame& k, Stamp value) { return k.stamp < value; });
    return static_cast<std::size_t>(found - key_frames_.begin());
  }

  double variance_at(Stamp stamp) const {
    const auto found = variances_.find(stamp);
    return found == variances_.end() ? 0.0 : found->second;
  }

  /// What odometry says of its own error between the key frames around a stretch: a turn that is
  /// wrong leads the farther astray the longer the way behind it. Over a break it says nothing.
  double claimed_error(const DoubtfulStretch& stretch) const {
    Covariance6 covariance = Covariance6::Zero();
    for (std::size_t i = std::max<std::size_t>(1, first_from(stretch.begin));
         i < key_frames_.size() && key_frames_[i - 1].stamp <= stretch.end; ++i) {
      const KeyFrame& from = key_frames_[i - 1];
      const KeyFrame& to = key_frames_[i];
      if (from.segment != to.segment) continue;
      covariance = compose_covariance(covariance, from.T_odom_base.inverse() * to.T_odom_base,
                                      to.motion_covariance);
    }
    return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  }

  /// Numbers of the last key frame before the stretch and of the first one after it.
  std::pair<std::size_t, std::size_t> key_frames_around(const DoubtfulStretch& stretch) const {
    const std::size_t behind = first_from(stretch.begin);
    return {behind > 0 ? behind - 1 : 0, std::min(first_from(stretch.end), key_frames_.size() - 1)};
  }

  /// Where what odometry claims is too much, what all of the graph leaves of it counts.
  void weigh_claim(DoubtfulStretch& stretch) const {
    const double allowed = allowed_error(stretch.way);
    if (stretch.expected_error <= allowed || key_frames_.empty()) return;
    const auto [before, last] = key_frames_around(stretch);
    const auto problem = back_end_.problem(true);
    const RelativeCovariance all(*problem, key_frames_[before].index,
                                 RelativeCovariance::Given::kAll);
    const auto covariance = all.of(key_frames_[last].index);
    if (!covariance) return;
    stretch.expected_error = std::sqrt(covariance->topLeftCorner<3, 3>().trace());
    stretch.is_trusted = stretch.expected_error <= allowed;
  }

  /// The error of a way that was not observed, at its key frames: by the speed that was believed,
  /// and less where the graph holds them from both sides.
  void weigh(DoubtfulStretch& stretch) const {
    const double allowed = allowed_error(stretch.way);
    if (stretch.expected_error <= allowed || key_frames_.empty()) return;
    const auto [before, last] = key_frames_around(stretch);
    const auto problem = back_end_.problem(true);
    const KeyFrameIndex from = key_frames_[before].index;
    const RelativeCovariance odometry(*problem, from, RelativeCovariance::Given::kOdometry);
    const RelativeCovariance all(*problem, from, RelativeCovariance::Given::kAll);
    const std::size_t step = (last - before) / kLooks + 1;
    double worst = 0.0;
    for (std::size_t i = last; i > before; i -= std::min(step, i - before)) {
      const KeyFrame& key_frame = key_frames_[i];
      const double variance = variance_at(key_frame.stamp) - variance_at(key_frames_[before].stamp);
      worst = std::max(worst,
                       remaining(variance, odometry.of(key_frame.index), all.of(key_frame.index)));
    }
    stretch.expected_error = std::sqrt(worst);
    stretch.is_trusted = stretch.expected_error <= allowed;
  }

  /// The graph's constraints say as much more than its odometry as its covariance is smaller; the
  /// same information is added to what is really known of the way.
  static double remaining(double variance, const std::optional<Covariance6>& of_odometry,
                          const std::optional<Covariance6>& of_all) {
    if (variance <= 0.0) return 0.0;
    if (!of_odometry || !of_all) return variance;
    const auto size = [](const Covariance6& c) { return c.topLeftCorner<3, 3>().trace(); };
    const double information = std::max(0.0, 1.0 / size(*of_all) - 1.0 / size(*of_odometry));
    return 1.0 / (1.0 / variance + information);
  }

  /// Between key frames that nothing ties together there is a lost stretch, or the drive was broken
  /// off there.
  void find_gaps(std::vector<DoubtfulStretch>& stretches) const {
    const std::vector<int> parts = back_end_.parts();
    for (std::size_t i = 1; i < std::min(parts.size(), key_frames_.size()); ++i) {
      if (parts[i] == parts[i - 1]) continue;
      DoubtfulStretch& gap = gap_between(key_frames_[i - 1].stamp, key_frames_[i].stamp, stretches);
      gap.is_trusted = false;
      gap.expected_error = std::numeric_limits<double>::infinity();
    }
  }

  static DoubtfulStretch& gap_between(Stamp begin, Stamp end,
                                      std::vector<DoubtfulStretch>& stretches) {
    for (DoubtfulStretch& stretch : stretches) {
      if (stretch.doubt == Doubt::kLost && stretch.begin <= end && stretch.end >= begin) {
        return stretch;
      }
    }
    DoubtfulStretch gap;
    gap.begin = begin;
    gap.end = end;
    const auto place =
        std::find_if(stretches.begin(), stretches.end(),
                     [&](const DoubtfulStretch& stretch) { return stretch.begin > begin; });
    return *stretches.insert(place, gap);
  }

  /// Where a stretch begins, moved as the key frame before it was.
  Eigen::Vector3d in_map(const DoubtfulStretch& stretch) const {
    const std::size_t behind = first_from(stretch.begin);
    if (key_frames_.empty()) return stretch.place;
    const KeyFrame& key_frame = key_frames_[behind > 0 ? behind - 1 : 0];
    const auto pose = T_map_base_.find(key_frame.index);
    if (pose == T_map_base_.end()) return stretch.place;
    if (stretch.scans == 0) return pose->second.translation;
    return pose->second * (key_frame.T_odom_base.inverse() * stretch.place);
  }

  std::vector<KeyFrame> key_frames_;
  const back_end::BackEnd& back_end_;
  std::map<Stamp, double> variances_;
  std::map<KeyFrameIndex, Pose> T_map_base_;
};

}  // namespace

bool DriveDoubt::is_trusted() const {
  return std::all_of(stretches.begin(), stretches.end(),
                     [](const DoubtfulStretch& stretch) { return stretch.is_trusted; });
}

DriveDoubt drive_doubt(const session::Session& session, const back_end::BackEnd& back_end,
                       const KeyFramePoses& poses) {
  const std::vector<session::ScanRecord> scans = session.scans();
  const TrackingSummary summary = summary_of(scans, session.odometry());
  DriveDoubt doubt;
  if (!scans.empty()) doubt.begin = scans.front().stamp;
  doubt.way = summary.way();
  doubt.stretches = summary.stretches();
  Judge(session, scans, back_end, poses).judge(doubt.stretches);
  return doubt;
}

}  // namespace lidar_mapping::pipeline
