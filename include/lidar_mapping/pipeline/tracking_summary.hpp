// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::pipeline {

/// Why the pose of a scan is less reliable than usual, from the least to the most severe reason.
enum class Doubt {
  kDoubtful,  ///< The match is accepted, but the step may be off by more than 0.3 m or 1 degree.
  /// The match is poor or probably wrong; the pose is used, but the scan is not in the local map.
  kDegraded,
  kRepeated,    ///< The points of the previous scan came again; the pose is a prediction.
  kDegenerate,  ///< The points do not observe one of the directions.
  kLost         ///< No match is accepted; the pose is a prediction.
};
/// Name of the reason: "doubtful", "degraded", "repeated", "degenerate" or "lost".
const char* to_string(Doubt doubt);
/// The reason that belongs to a state as front end and session name it; none for "tracking".
std::optional<Doubt> doubt_of_state(const std::string& state);

/// What the front end reported about one scan.
struct TrackedStep {
  Stamp stamp = 0;             ///< Stamp of the scan, ns.
  std::optional<Doubt> doubt;  ///< None if the scan was tracked without doubt.
  /// Position by odometry, m.
  Eigen::Vector3d p_odom_base = Eigen::Vector3d::Zero();
  double unobserved_stddev = 0.0;     ///< FrontEndStatus::unobserved_stddev, m.
  std::optional<double> probability;  ///< Probability that the step is right, if known.
  /// Whether no path leads here from the scan before, as where a drive was gone on with.
  bool begins_drive = false;
  std::size_t drive = 0;  ///< Number of the drive; no path leads from one drive to another.
};

/// The first and the last one of consecutive key frames of a drive.
struct KeyFrameRange {
  KeyFrameIndex first = 0;  ///< index
  KeyFrameIndex last = 0;   ///< index; at least that of the first one
};

/// A section of the drive whose scans are doubtful for the same reason.
struct DoubtfulSection {
  Doubt doubt = Doubt::kLost;  ///< The common reason.
  std::size_t drive = 0;       ///< Number of the drive, of which it is a section.
  Stamp begin = 0;             ///< Stamp of the first scan, ns.
  Stamp end = 0;               ///< Stamp of the last scan, ns.
  std::size_t scans = 0;       ///< Number of doubtful scans.
  /// Path length by odometry from the beginning of the drive to the section, m.
  double path_begin = 0.0;
  double path_length =
      0.0;  ///< Path length of the section, including the step that leads into it, m.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Position at its beginning, m.
  /// Standard deviation of the error, m. In TrackingSummary it is that over the section from
  /// directions that nothing observed; after drive_doubt() it is that of its end given all
  /// constraints of the graph. Infinite if unknown.
  double expected_error = 0.0;
  /// Smallest probability that a step is right, if any scan has one.
  std::optional<double> lowest_probability;
  bool is_trusted = true;  ///< Whether the map can be relied on here.
  /// From the last key frame of the drive before the section to the first one after it; none in
  /// TrackingSummary, and where the drive has no key frames.
  std::optional<KeyFrameRange> key_frames;
};

/// By the format of doubt.csv and of the report: stands for a lowest_probability that is not known.
constexpr double kUnknownProbability = -1.0;

/// Groups doubtful scans into sections. Scans with the same reason that are at most a second apart
/// belong to one section, because a person looks at sections and not at each scan.
class TrackingSummary {
 public:
  /// Adds the next scan. Drives come one after the other; in each of them stamps have to increase.
  void add(const TrackedStep& step);

  /// All sections so far, drive by drive in the order in which they begin.
  const std::vector<DoubtfulSection>& sections() const { return sections_; }
  /// Number of all scans so far.
  std::size_t scans() const { return scans_; }
  double path_length() const { return path_length_; }  ///< Path length of the whole drive, m.

 private:
  void advance_to(const TrackedStep& step);
  DoubtfulSection& section_for(Doubt doubt, const TrackedStep& step);

  std::vector<DoubtfulSection> sections_;
  /// Variance of the unobserved travel before each section, m^2.
  std::vector<double> variances_before_;
  double variance_ = 0.0;         ///< Variance of the unobserved travel so far, m^2.
  double variance_before_ = 0.0;  ///< up to the scan before
  std::optional<TrackedStep> last_;
  std::size_t scans_ = 0;
  double path_length_ = 0.0;
  double path_length_before_ = 0.0;  ///< up to the scan before
};

/// Error that a map may have over a section of this path length, both in m: 1 % of the length and
/// at least half a metre, which is what map_quality allows for odometry.
double allowed_error(double path_length);

}  // namespace lidar_mapping::pipeline
