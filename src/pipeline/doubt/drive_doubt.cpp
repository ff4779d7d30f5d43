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
#include "lidar_mapping/pipeline/session_drives.hpp"
#include "lidar_mapping/pipeline/session_part.hpp"

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

/// Finds where a drive was interrupted and gone on with: a pause behind which a new segment begins.
/// The odometry begins anew there, and in between nothing was travelled. It also separates the
/// drives of merged sessions of an older version, which do not tell them apart.
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

/// Walks through one drive after the other: between the vehicles of two that overlap in time there
/// is no path.
TrackingSummary summary_of(const std::vector<session::ScanRecord>& scans,
                           const std::vector<SessionDrive>& drives) {
  const std::map<Stamp, session::ScanRecord> records = by_stamp(scans);
  TrackingSummary summary;
  for (std::size_t drive = 0; drive < drives.size(); ++drive) {
    const DriveBegins begins(in_order_of_time(drives[drive].key_frames));
    std::optional<Stamp> before;
    for (const session::ScanOdometry& scan : drives[drive].odometry) {
      const auto found = records.find(scan.stamp);
      if (found == records.end()) continue;
      const session::ScanRecord& record = found->second;
      summary.add({scan.stamp, doubt_of_state(record.state), scan.T_odom_base.translation,
                   record.unobserved_stddev, record.probability,
                   before && begins.has(*before, scan.stamp), drive});
      before = scan.stamp;
    }
  }
  return summary;
}

std::vector<DoubtfulSection> in_order_of_time(std::vector<DoubtfulSection> sections) {
  std::stable_sort(sections.begin(), sections.end(),
                   [](const auto& a, const auto& b) { return a.begin < b.begin; });
  return sections;
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

/// The key frames of one drive.
struct DriveTrack {
  std::vector<KeyFrame> key_frames;  ///< See in_order_of_time().
  std::vector<double> variances;     ///< See unobserved_variances().

  /// Position of the first key frame at or after a stamp; the number of all if there is none.
  std::size_t first_from(Stamp stamp) const {
    return static_cast<std::size_t>(first_not_before(key_frames, stamp) - key_frames.begin());
  }
  /// Positions of the last key frame before the section and of the first one after it.
  std::pair<std::size_t, std::size_t> around(const DoubtfulSection& section) const {
    const std::size_t next = first_from(section.begin);
    return {next > 0 ? next - 1 : 0, std::min(first_from(section.end), key_frames.size() - 1)};
  }
};

/// Assesses sections with the key frames and the graph.
class SectionAssessment {
 public:
  SectionAssessment(const std::vector<SessionDrive>& drives,
                    const std::vector<session::ScanRecord>& scans,
                    const back_end::BackEnd& back_end, const KeyFramePoses& poses)
      : back_end_(back_end) {
    for (const SessionDrive& drive : drives) {
      DriveTrack& track = tracks_.emplace_back();
      track.key_frames = in_order_of_time(drive.key_frames);
      track.variances = unobserved_variances(track.key_frames, scans);
    }
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
    for (DoubtfulSection& section : sections) {
      section.position = position_in_map(section);
      section.key_frames = key_frames_around(section);
    }
  }

 private:
  /// Error that the odometry claims between the key frames around a section. Errors of rotation
  /// grow with the path length behind them. Between two segments the odometry claims nothing.
  double claimed_error(const DoubtfulSection& section) const {
    const DriveTrack& track = tracks_[section.drive];
    Covariance6 covariance = Covariance6::Zero();
    for (std::size_t i = std::max<std::size_t>(1, track.first_from(section.begin));
         i < track.key_frames.size() && track.key_frames[i - 1].stamp <= section.end; ++i) {
      const KeyFrame& from = track.key_frames[i - 1];
      const KeyFrame& to = track.key_frames[i];
      if (from.segment != to.segment) continue;
      covariance = compose_covariance(covariance, from.T_odom_base.inverse() * to.T_odom_base,
                                      to.motion_covariance);
    }
    return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
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
    const DriveTrack& track = tracks_[section.drive];
    if (section.expected_error <= allowed || track.key_frames.empty()) return;
    const auto [before, last] = track.around(section);
    const RelativeCovariance all(problem(), track.key_frames[before].index,
                                 RelativeCovariance::Given::kAll);
    const auto covariance = all.of(track.key_frames[last].index);
    if (!covariance) return;
    section.expected_error = std::sqrt(covariance->topLeftCorner<3, 3>().trace());
    section.is_trusted = section.expected_error <= allowed;
  }

  /// Error of unobserved travel at the key frames of a section. It follows from the predicted
  /// speed, and is smaller if the graph constrains the key frames from both sides.
  void assess_unobserved(DoubtfulSection& section) {
    const double allowed = allowed_error(section.path_length);
    const DriveTrack& track = tracks_[section.drive];
    if (section.expected_error <= allowed || track.key_frames.empty()) return;
    const auto [before, last] = track.around(section);
    const KeyFrameIndex from = track.key_frames[before].index;
    const RelativeCovariance odometry(problem(), from, RelativeCovariance::Given::kOdometry);
    const RelativeCovariance all(problem(), from, RelativeCovariance::Given::kAll);
    const std::size_t step = (last - before) / kCheckedKeyFrames + 1;
    double worst = 0.0;
    for (std::size_t i = last; i > before; i -= std::min(step, i - before)) {
      const KeyFrame& key_frame = track.key_frames[i];
      const double variance = track.variances[i] - track.variances[before];
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

  /// Between key frames of unconnected parts of the graph the odometry was lost, the drive was
  /// interrupted, or another one begins.
  void mark_gaps(std::vector<DoubtfulSection>& sections) {
    std::optional<GapEnd> before;
    for (std::size_t drive = 0; drive < tracks_.size(); ++drive) {
      for (const KeyFrame& key_frame : tracks_[drive].key_frames) {
        const GapEnd after{drive, key_frame.stamp, parts_[key_frame.index]};
        if (before && before->part != after.part) {
          DoubtfulSection& gap = gap_section(*before, after, sections);
          gap.is_trusted = false;
          gap.expected_error = std::numeric_limits<double>::infinity();
        }
        before = after;
      }
    }
  }

  /// A key frame at a gap.
  struct GapEnd {
    std::size_t drive;
    Stamp stamp;
    int part;  ///< of the graph
  };

  static DoubtfulSection& gap_section(const GapEnd& before, const GapEnd& after,
                                      std::vector<DoubtfulSection>& sections) {
    DoubtfulSection gap;
    gap.drive = before.drive;
    // A drive that begins while the one before still lasts is apart from its begin on.
    gap.begin = std::min(before.stamp, after.stamp);
    gap.end = after.stamp;
    for (DoubtfulSection& section : sections) {
      const bool is_beside = section.drive == before.drive || section.drive == after.drive;
      if (section.doubt == Doubt::kLost && is_beside && section.begin <= gap.end &&
          section.end >= gap.begin) {
        return section;
      }
    }
    const auto position =
        std::find_if(sections.begin(), sections.end(),
                     [&](const DoubtfulSection& section) { return section.begin > gap.begin; });
    return *sections.insert(position, gap);
  }

  /// Begin of a section in the map: moved as the key frame before it.
  Eigen::Vector3d position_in_map(const DoubtfulSection& section) const {
    const DriveTrack& track = tracks_[section.drive];
    if (track.key_frames.empty()) return section.position;
    const KeyFrame& key_frame = track.key_frames[track.around(section).first];
    const auto pose = T_map_base_.find(key_frame.index);
    if (pose == T_map_base_.end()) return section.position;
    if (section.scans == 0) return pose->second.translation;
    return pose->second * (key_frame.T_odom_base.inverse() * section.position);
  }

  std::optional<KeyFrameRange> key_frames_around(const DoubtfulSection& section) const {
    const DriveTrack& track = tracks_[section.drive];
    if (track.key_frames.empty()) return std::nullopt;
    const auto [before, last] = track.around(section);
    // Segments of an old session may be numbered in another order than that of time.
    const auto [first_index, last_index] =
        std::minmax(track.key_frames[before].index, track.key_frames[last].index);
    return KeyFrameRange{first_index, last_index};
  }

  std::vector<DriveTrack> tracks_;      ///< Of each drive.
  std::map<KeyFrameIndex, int> parts_;  ///< Connected part of the graph of each key frame.
  const back_end::BackEnd& back_end_;
  std::shared_ptr<const back_end::OptimizationProblem> problem_;
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
  const std::vector<SessionDrive> drives = drives_of(session);
  const TrackingSummary summary = summary_of(scans, drives);
  DriveDoubt doubt;
  if (!scans.empty()) doubt.begin = scans.front().stamp;
  doubt.path_length = summary.path_length();
  doubt.sections = in_order_of_time(summary.sections());
  SectionAssessment(drives, scans, back_end, poses).assess(doubt.sections);
  return doubt;
}

}  // namespace lidar_mapping::pipeline
