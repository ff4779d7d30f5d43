// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/back_end/key_frame_deviation.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"
#include "lidar_mapping/session/session.hpp"

#include "json.hpp"

namespace lidar_mapping::report {

/// Session and poses of a map, as input of the figures.
struct ReportInput {
  const session::Session& session;
  KeyFramePoses poses;  ///< newest, T_map_base
  /// Moved so that the first key frame of each segment has the pose that it has in `poses`.
  KeyFramePoses odometry;
  std::vector<std::size_t> drives;  ///< the number of the drive of each pose, in order of time
  std::vector<double> distances;    ///< travelled up to each pose, m; nothing between two drives
  std::optional<Trajectory> truth;
};

/// Optimised poses, and odometry after the last of them.
ReportInput report_input(const session::Session& session, std::optional<Trajectory> truth = {});
/// Whether the graph has moved the map to East-North-Up.
bool is_in_enu(const session::Session& session);
/// The session's graph, solved again.
std::unique_ptr<back_end::BackEnd> solved_graph(const session::Session& session);

// Parts of report.json; lengths in m, angles in deg.
/// Recording, sensors, software, command and coordinates; null if unknown.
json::Json origin_figures(const ReportInput& input);
/// Files of the session and its map, with their sizes, and the map's extent where there is one.
json::Json product_figures(const ReportInput& input);
json::Json drive_figures(const ReportInput& input);
/// Path length, position and distance from odometry of every key frame.
json::Json trajectory_figures(const ReportInput& input);
/// Residuals of loops and GNSS at the newest poses.
json::Json loop_figures(const ReportInput& input);
json::Json gnss_figures(const ReportInput& input, const back_end::BackEnd& back_end);
json::Json scan_figures(const ReportInput& input);
/// Standard deviations of key frames relative to the first one along the path, the largest of these
/// and of neighbours, numbers of those not connected to the first and of doubtful ones, and the
/// longest part of the path without a loop or GNSS.
json::Json uncertainty_figures(const ReportInput& input, const back_end::BackEnd& back_end,
                               const std::vector<back_end::KeyFrameDeviation>& deviations);
/// The same for each key frame as CSV text.
std::string key_frame_table(const ReportInput& input,
                            const std::vector<back_end::KeyFrameDeviation>& deviations);
/// Doubtful sections of the map, with the key frames around them; see drive_doubt().
json::Json doubt_figures(const ReportInput& input, const back_end::BackEnd& back_end);
/// APE, RPE and KITTI's errors; null without truth. Figures for which the path is too short are
/// null, too. Throws InputError if less than three key frames have a true pose.
json::Json truth_figures(const ReportInput& input);

json::Json to_json(const map_quality::LocalThickness& thickness, bool has_ratio);
json::Json to_json(const map_quality::PassMisalignment& misalignment);
json::Json to_json(const map_quality::MapEntropy& entropy);

/// A row for each figure: name, value in words, whether it is good, a note, and the limit.
json::Json verdicts(const json::Json& report);

/// One sentence about the whole map: the figures that a user has to check.
std::string overall_verdict(const json::Json& report);

}  // namespace lidar_mapping::report
