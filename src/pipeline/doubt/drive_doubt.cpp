// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/drive_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "lidar_mapping/back_end/relative_covariance.hpp"
#include "lidar_mapping/common/sorted_values.hpp"

namespace lidar_mapping::pipeline {

namespace {

using back_end::RelativeCovariance;

/// Number of key frames of a section at which the error is computed. Chosen: bounds the time; the
/// error grows slowly from one key frame to the next.
constexpr std::size_t kCheckedKeyFrames = 8;

/// Segment by segment, in the order in which these begin: drives may have been merged in another
/// one.
std::vector<KeyFrame> in_order_of_time(std::vector<KeyFrame> key_frames) {
  std::map<std::uint32_t, Stamp> begins;
  for (const KeyFrame& key_frame : key_frames) begins.emplace(key_frame.segment, key_frame.stamp);
  std::stable_sort(key_frames.begin(), key_frames.end(), [&](const auto& a, const auto& b) {
    return begins.at(a.segment) < begins.at(b.segment);
  });
  return key_frames;
}

/// Finds where one drive ends and the next begins: a pause behind which a new segment does. The
/// odometry of the next drive begins anew, and between the two nothing was travelled.
class DriveBegins {
 public:
  /// `key_frames` are in the order of in_order_of_time().
  explicit DriveBegins(const std::vector<KeyFrame>& key_frames) {
    for (std::size_t i = 1; i < key_frames.size(); ++i) {
      if (key_frames[i].segment == key_frames[i - 1].segment) continue;
      breaks_.emplace_back(key_frames[i - 1].stamp, key_frames[i].stamp);
    }
  }
  /// Whether a drive begins with the scan at `stamp`; the scan before it has the stamp `before`.
  bool has(Stamp before, Stamp stamp) const {
    return stamp - before > kLeastPause &&
           std::any_of(breaks_.begin(), breaks_.end(), [&](const auto& segments) {
             return segments.first <= before && stamp <= segments.second;
           });
  }

 private:
  /// ns. Chosen: longer than from scan to scan, shorter than between two drives.
  static constexpr Stamp kLeastPause = from_seconds(1.0);

  /// Stamps of the last key frame of a segment and of the first one of the next.
  std::vector<std::pair<Stamp, Stamp>> breaks_;
};

TrackingSummary summary_of(const std::vector<session::ScanRecord>& scans,
                           const std::vector<std::pair<Stamp, Pose>>& odometry,
                           const DriveBegins& begins) {
  std::map<Stamp, Eigen::Vector3d> positions;
  for (const auto& [stamp, T_odom_base] : odometry) positions[stamp] = T_odom_base.translation;
  TrackingSummary summary;
  std::optional<Stamp> before;
  for (const session::ScanRecord& scan : scans) {
    const auto position = positions.find(scan.stamp);
    if (position == positions.end()) continue;
    summary.add({scan.stamp, doubt_of_state(scan.state), position->second, scan.unobserved_stddev,
                 scan.probability, before && begins.has(*before, scan.stamp)});
    before = scan.stamp;
  }
  return summary;
}

/// Variance of the unobserved travel up to each key frame, m^2. A front end that is started again
/// begins at 0, in a new segment; what came before stays in the path.
std::vector<double> unobserved_variances(const std::vector<KeyFrame>& key_frames,
                                         const std::vector<session::ScanRecord>& scans) {
  std::map<Stamp, double> reported;
  for (const session::ScanRecord& scan : scans) {
    reported[scan.stamp] = scan.unobserved_stddev * scan.unobserved_stddev;
  }
  std::vector<double> variances;
  double of_earlier_runs = 0.0;
  double newest = 0.0;
  for (std::size_t i = 0; i < key_frames.size(); ++i) {
    const auto found = reported.find(key_frames[i].stamp);
    if (found != reported.end()) {
      const bool is_restart =
          i > 0 && key_frames[i].segment != key_frames[i - 1].segment && found->second < newest;
      if (is_restart) of_earlier_runs += newest;
      newest = found->second;
    }
    variances.push_back(of_earlier_runs + newest);
  }
  return variances;
}

/// Assesses sections with the key frames and the graph.
class SectionAssessment {
 public:
  SectionAssessment(const session::Session& session, const std::vector<session::ScanRecord>& scans,
                    const back_end::BackEnd& back_end, const KeyFramePoses& poses)
      : key_frames_(in_order_of_time(session.key_frames())),
        back_end_(back_end),
        variances_(unobserved_variances(key_frames_, scans)) {
    for (const KeyFramePose& pose : poses.poses) T_map_base_[pose.index] = pose.T_map_base;
    const std::vector<KeyFramePose> nodes = back_end.poses().poses;
    const std::vector<int> parts = back_end.parts();
    for (std::size_t i = 0; i < parts.size(); ++i) parts_[nodes[i].index] = parts[i];
  }

  void assess(std::vector<DoubtfulSection>& sections) {
    for (DoubtfulSection& section : sections) {
      if (section.doubt == Doubt::kDegenerate) {
        assess_unobserved(section);
      } else {
        section.expected_error = claimed_error(section);
        if (section.doubt != Doubt::kLost) assess_claim(section);
      }
    }
    mark_gaps(sections);
    for (DoubtfulSection& section : sections) section.position = position_in_map(section);
  }

 private:
  /// Position in key_frames_ of the first key frame at or after a stamp; its size if there is none.
  std::size_t first_key_frame_from(Stamp stamp) const {
    return static_cast<std::size_t>(first_not_before(key_frames_, stamp) - key_frames_.begin());
  }

  /// Error that the odometry claims between the key frames around a section. Errors of rotation
  /// grow with the path length behind them. Between two segments the odometry claims nothing.
  double claimed_error(const DoubtfulSection& section) const {
    Covariance6 covariance = Covariance6::Zero();
    for (std::size_t i = std::max<std::size_t>(1, first_key_frame_from(section.begin));
         i < key_frames_.size() && key_frames_[i - 1].stamp <= section.end; ++i) {
      const KeyFrame& from = key_frames_[i - 1];
      const KeyFrame& to = key_frames_[i];
      if (from.segment != to.segment) continue;
      covariance = compose_covariance(covariance, from.T_odom_base.inverse() * to.T_odom_base,
                                      to.motion_covariance);
    }
    return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  }

  /// Positions of the last key frame before the section and of the first one after it.
  std::pair<std::size_t, std::size_t> key_frames_around(const DoubtfulSection& section) const {
    const std::size_t next = first_key_frame_from(section.begin);
    return {next > 0 ? next - 1 : 0,
            std::min(first_key_frame_from(section.end), key_frames_.size() - 1)};
  }

  /// The whole graph. It is copied once, and only if a section needs it.
  const back_end::OptimizationProblem& problem() {
    if (!problem_) problem_ = back_end_.problem(true);
    return *problem_;
  }

  /// If the error that the odometry claims is too large, the error that remains given the whole
  /// graph decides.
  void assess_claim(DoubtfulSection& section) {
    const double allowed = allowed_error(section.path_length);
    if (section.expected_error <= allowed || key_frames_.empty()) return;
    const auto [before, last] = key_frames_around(section);
    const RelativeCovariance all(problem(), key_frames_[before].index,
                                 RelativeCovariance::Given::kAll);
    const auto covariance = all.of(key_frames_[last].index);
    if (!covariance) return;
    section.expected_error = std::sqrt(covariance->topLeftCorner<3, 3>().trace());
    section.is_trusted = section.expected_error <= allowed;
  }

  /// Error of unobserved travel at the key frames of a section. It follows from the predicted
  /// speed, and is smaller if the graph constrains the key frames from both sides.
  void assess_unobserved(DoubtfulSection& section) {
    const double allowed = allowed_error(section.path_length);
    if (section.expected_error <= allowed || key_frames_.empty()) return;
    const auto [before, last] = key_frames_around(section);
    const KeyFrameIndex from = key_frames_[before].index;
    const RelativeCovariance odometry(problem(), from, RelativeCovariance::Given::kOdometry);
    const RelativeCovariance all(problem(), from, RelativeCovariance::Given::kAll);
    const std::size_t step = (last - before) / kCheckedKeyFrames + 1;
    double worst = 0.0;
    for (std::size_t i = last; i > before; i -= std::min(step, i - before)) {
      const KeyFrame& key_frame = key_frames_[i];
      const double variance = variances_[i] - variances_[before];
      worst = std::max(worst, remaining_variance(variance, odometry.of(key_frame.index),
                                                 all.of(key_frame.index)));
    }
    section.expected_error = std::sqrt(worst);
    section.is_trusted = section.expected_error <= allowed;
  }

  /// Variance that remains. The information that the whole graph has in addition to its odometry
  /// follows from the two covariances, and is added to the information about the unobserved travel.
  static double remaining_variance(double variance, const std::optional<Covariance6>& of_odometry,
                                   const std::optional<Covariance6>& of_all) {
    if (variance <= 0.0) return 0.0;
    if (!of_odometry || !of_all) return variance;
    const auto size = [](const Covariance6& c) { return c.topLeftCorner<3, 3>().trace(); };
    const double information = std::max(0.0, 1.0 / size(*of_all) - 1.0 / size(*of_odometry));
    return 1.0 / (1.0 / variance + information);
  }

  /// Between key frames of unconnected parts of the graph the odometry was lost, or the drive was
  /// interrupted.
  void mark_gaps(std::vector<DoubtfulSection>& sections) {
    for (std::size_t i = 1; i < key_frames_.size(); ++i) {
      const KeyFrame& before = key_frames_[i - 1];
      const KeyFrame& after = key_frames_[i];
      if (parts_[before.index] == parts_[after.index]) continue;
      DoubtfulSection& gap = gap_section(before.stamp, after.stamp, sections);
      gap.is_trusted = false;
      gap.expected_error = std::numeric_limits<double>::infinity();
    }
  }

  static DoubtfulSection& gap_section(Stamp begin, Stamp end,
                                      std::vector<DoubtfulSection>& sections) {
    for (DoubtfulSection& section : sections) {
      if (section.doubt == Doubt::kLost && section.begin <= end && section.end >= begin) {
        return section;
      }
    }
    DoubtfulSection gap;
    gap.begin = begin;
    gap.end = end;
    const auto position =
        std::find_if(sections.begin(), sections.end(),
                     [&](const DoubtfulSection& section) { return section.begin > begin; });
    return *sections.insert(position, gap);
  }

  /// Begin of a section in the map: moved as the key frame before it.
  Eigen::Vector3d position_in_map(const DoubtfulSection& section) const {
    const std::size_t next = first_key_frame_from(section.begin);
    if (key_frames_.empty()) return section.position;
    const KeyFrame& key_frame = key_frames_[next > 0 ? next - 1 : 0];
    const auto pose = T_map_base_.find(key_frame.index);
    if (pose == T_map_base_.end()) return section.position;
    if (section.scans == 0) return pose->second.translation;
    return pose->second * (key_frame.T_odom_base.inverse() * section.position);
  }

  std::vector<KeyFrame> key_frames_;    ///< See in_order_of_time().
  std::map<KeyFrameIndex, int> parts_;  ///< Connected part of the graph of each key frame.
  const back_end::BackEnd& back_end_;
  std::shared_ptr<const back_end::OptimizationProblem> problem_;
  std::vector<double> variances_;  ///< See unobserved_variances().
  std::map<KeyFrameIndex, Pose> T_map_base_;
};

}  // namespace

bool DriveDoubt::is_trusted() const {
  return std::all_of(sections.begin(), sections.end(),
                     [](const DoubtfulSection& section) { return section.is_trusted; });
}

DriveDoubt drive_doubt(const session::Session& session, const back_end::BackEnd& back_end,
                       const KeyFramePoses& poses) {
  const std::vector<session::ScanRecord> scans = session.scans();
  const TrackingSummary summary =
      summary_of(scans, session.odometry(), DriveBegins(in_order_of_time(session.key_frames())));
  DriveDoubt doubt;
  if (!scans.empty()) doubt.begin = scans.front().stamp;
  doubt.path_length = summary.path_length();
  doubt.sections = summary.sections();
  SectionAssessment(session, scans, back_end, poses).assess(doubt.sections);
  return doubt;
}

}  // namespace lidar_mapping::pipeline
