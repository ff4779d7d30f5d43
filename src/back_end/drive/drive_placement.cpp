// SPDX-License-Identifier: BSD-3-Clause
#include "drive/drive_placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "gnss/gnss_alignment.hpp"
#include "gnss/gnss_delay.hpp"
#include "gnss/gnss_weights.hpp"

namespace lidar_mapping::back_end {

namespace {

/// Moves all nodes of the selected segments by one rigid motion.
void transform_segments(DriveGraph& drive, const std::vector<bool>& segments,
                        const Pose& T_new_old) {
  for (std::size_t i = 0; i < drive.nodes.size(); ++i) {
    if (!segments[drive.segment_of(static_cast<int>(i))]) continue;
    drive.nodes[i].T_map_base = T_new_old * drive.nodes[i].T_map_base;
  }
  if (segments.front()) drive.T_map_first = T_new_old * drive.T_map_first;
}

std::vector<bool> group_members(const std::vector<int>& connected, int group) {
  std::vector<bool> result;
  for (const int g : connected) result.push_back(g == group);
  return result;
}

/// The motion of what lies at the end of the loop, or else of what lies at its begin, that makes
/// the loop fit.
Pose correction_by_loop(const DriveGraph& drive, const DriveLoop& loop, bool of_end) {
  const Pose& from = drive.nodes[loop.from].T_map_base;
  const Pose& to = drive.nodes[loop.to].T_map_base;
  const Pose correction = from * loop.loop.T_from_to * to.inverse();
  return of_end ? correction : correction.inverse();
}

/// What each new loop between the group and segments that are placed would move the group by.
std::vector<Pose> corrections_of(const DriveGraph& drive, const std::vector<int>& groups, int group,
                                 const std::vector<bool>& placed) {
  std::vector<Pose> corrections;
  for (const DriveLoop& loop : drive.loops) {
    if (loop.evaluated) continue;
    const auto from = static_cast<std::size_t>(drive.segment_of(loop.from));
    const auto to = static_cast<std::size_t>(drive.segment_of(loop.to));
    if (groups[from] == group && placed[to])
      corrections.push_back(correction_by_loop(drive, loop, false));
    else if (groups[to] == group && placed[from])
      corrections.push_back(correction_by_loop(drive, loop, true));
  }
  return corrections;
}

/// A motion of a group of segments, and how many loops agree with it.
struct GroupPlacement {
  int group = 0;
  Pose T_new_old;
  std::ptrdiff_t votes = 0;
};

/// The correction that most others agree with; the first of them if there are several.
std::optional<GroupPlacement> most_agreed(int group, const std::vector<Pose>& corrections,
                                          const Eigen::Vector3d& p_map_start) {
  // Chosen: with more, false loops seem to agree; with less, drift separates true ones.
  constexpr double kAgreementDistance_m = 2.0;
  std::optional<GroupPlacement> best;
  for (const Pose& a : corrections) {
    const auto votes = std::count_if(corrections.begin(), corrections.end(), [&](const Pose& b) {
      return (a * p_map_start - b * p_map_start).norm() < kAgreementDistance_m;
    });
    if (!best || votes > best->votes) best = GroupPlacement{group, a, votes};
  }
  return best;
}

/// Of the groups that have loops to placed segments, the one with most agreeing loops.
std::optional<GroupPlacement> next_placement(const DriveGraph& drive,
                                             const std::vector<int>& groups,
                                             const std::vector<bool>& placed) {
  std::optional<GroupPlacement> best;
  for (std::size_t segment = 0; segment < groups.size(); ++segment) {
    const int group = groups[segment];
    if (placed[segment] || static_cast<std::size_t>(group) != segment) continue;
    const int start = drive.segment_starts[segment];
    const std::optional<GroupPlacement> candidate =
        most_agreed(group, corrections_of(drive, groups, group, placed),
                    drive.nodes[start].T_map_base.translation);
    if (candidate && (!best || candidate->votes > best->votes)) best = candidate;
  }
  return best;
}

/// A segment that was placed beside one that is not in East-North-Up has left it: the two are to be
/// aligned together.
void reset_alignments(const std::vector<int>& groups, const std::vector<int>& by_new_loops,
                      DriveGraph& drive) {
  const std::vector<bool> group_in_enu = groups_in_enu(drive, groups);
  for (std::size_t segment = 0; segment < groups.size(); ++segment) {
    const int oldest = by_new_loops[segment];
    const bool is_moved = groups[segment] != oldest;
    if (is_moved && !group_in_enu[oldest]) drive.in_enu[segment] = false;
  }
}

std::vector<AlignmentSample> alignment_samples(const DriveGraph& drive,
                                               const std::vector<bool>& segments,
                                               const BackEndConfig& config) {
  std::vector<AlignmentSample> samples;
  for (const DriveGnss& gnss : drive.gnss) {
    if (!segments[drive.segment_of(gnss.node)]) continue;
    const GnssPosition p = delay_corrected_position(drive, gnss);
    AlignmentSample sample;
    sample.p_enu = p.p_enu_antenna;
    if (!has_altitude(p)) sample.p_enu.z() = std::numeric_limits<double>::quiet_NaN();
    sample.p_map = drive.nodes[gnss.node].T_map_base * p.p_base_antenna;
    sample.stddev_horizontal = horizontal_stddev(p, config);
    sample.stddev_altitude = altitude_stddev(p, config);
    samples.push_back(sample);
  }
  return samples;
}

AlignmentLimits alignment_limits(const BackEndConfig& config) {
  return {config.gnss_alignment_distance, config.gnss_alignment_stddev};
}

/// Aligns the whole track, or its beginning if the whole track has drifted too far.
std::optional<Alignment> align_track(const std::vector<AlignmentSample>& samples,
                                     const Eigen::Quaterniond& R_level_map,
                                     const BackEndConfig& config) {
  const AlignmentLimits limits = alignment_limits(config);
  auto alignment = align_to_enu(samples, R_level_map, limits);
  for (std::size_t count = 16; !alignment && count < samples.size(); count *= 2) {
    const std::vector<AlignmentSample> first_samples(samples.begin(),
                                                     samples.begin() + static_cast<long>(count));
    alignment = align_to_enu(first_samples, R_level_map, limits);
  }
  return alignment;
}

}  // namespace

void connect_segments(DriveGraph& drive) {
  const std::vector<int> groups = connected_segments(drive, false);
  const std::vector<int> by_new_loops = connected_segments(drive, true);
  std::vector<bool> placed(groups.size(), false);
  for (std::size_t segment = 0; segment < groups.size(); ++segment)
    placed[segment] = groups[segment] == by_new_loops[segment];
  // A group may be connected by way of another one, which has to be placed before it.
  while (const std::optional<GroupPlacement> next = next_placement(drive, groups, placed)) {
    const std::vector<bool> segments = group_members(groups, next->group);
    transform_segments(drive, segments, next->T_new_old);
    for (std::size_t segment = 0; segment < segments.size(); ++segment)
      if (segments[segment]) placed[segment] = true;
  }
  reset_alignments(groups, by_new_loops, drive);
}

Georeference georeference(DriveGraph& drive, const BackEndConfig& config, bool realign) {
  if (!config.use_gnss || drive.gnss.empty()) return {};
  Georeference result;
  const std::vector<int> connected = connected_segments(drive, true);
  for (int group = 0; group < static_cast<int>(connected.size()); ++group) {
    const std::vector<bool> segments = group_members(connected, group);
    bool was_aligned = false;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      was_aligned = was_aligned || (segments[s] && drive.in_enu[s]);
    }
    if (was_aligned && !realign) continue;
    const auto alignment = align_track(alignment_samples(drive, segments, config),
                                       gravity_alignment(drive, segments, config), config);
    if (!alignment) continue;
    transform_segments(drive, segments, alignment->T_enu_map);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (segments[s]) drive.in_enu[s] = true;
    }
    result.newly_aligned = result.newly_aligned || !was_aligned;
    result.rms_horizontal = alignment->rms_horizontal;
    result.inliers += static_cast<std::size_t>(alignment->inliers);
  }
  return result;
}

void shift_to_gnss(const DriveGraph& drive, const BackEndConfig& config,
                   pose_graph::FactorGraph& graph) {
  // Positions. Chosen: in longer sections drift bends the track, in shorter ones noise turns it.
  constexpr std::size_t kSectionSamples = 100;
  DriveGraph shifted = drive;
  for (std::size_t i = 0; i < shifted.nodes.size(); ++i) {
    shifted.nodes[i].T_map_base = graph.pose(static_cast<int>(i));
  }
  const std::vector<bool> all_segments(drive.in_enu.size(), true);
  const std::vector<AlignmentSample> samples = alignment_samples(shifted, all_segments, config);
  Pose correction;
  std::size_t node = 0;
  for (std::size_t begin = 0; begin < samples.size(); begin += kSectionSamples / 2) {
    const std::size_t end = std::min(begin + kSectionSamples, samples.size());
    const auto alignment = align_to_enu(
        {samples.begin() + static_cast<long>(begin), samples.begin() + static_cast<long>(end)},
        Eigen::Quaterniond::Identity(), alignment_limits(config));
    if (alignment) correction = alignment->T_enu_map;
    const std::size_t middle = std::min(begin + 3 * kSectionSamples / 4, samples.size() - 1);
    const std::size_t end_node = end == samples.size()
                                     ? shifted.nodes.size()
                                     : static_cast<std::size_t>(drive.gnss[middle].node);
    for (; node < end_node; ++node) {
      if (!drive.in_enu[drive.segment_of(static_cast<int>(node))]) continue;
      graph.set_pose(static_cast<int>(node), correction * shifted.nodes[node].T_map_base);
    }
  }
}

}  // namespace lidar_mapping::back_end
