// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/pipeline/tracking_summary.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// The sections of a drive where its map is doubtful, and how large the error may be there.
struct DriveDoubt {
  Stamp begin = 0;           ///< Stamp of the first scan of the drive.
  double path_length = 0.0;  ///< Path length of the whole drive, or of all that were merged, m.
  /// In the order in which they begin; positions are in the map frame.
  std::vector<DoubtfulSection> sections;

  /// False if the map must not be relied on in any of the sections.
  bool is_trusted() const;
};

/// Assesses what the front end reported about the scans with the help of the whole graph:
/// - A section in which the odometry was lost is not trusted if neither loops nor GNSS connect the
///   key frames before and after it.
/// - A degenerate section is not trusted if the error that may have arisen there exceeds
///   allowed_error(). This error is that of a path length that follows from the predicted speed
///   alone, reduced by what odometry, loops and GNSS contribute.
/// - All other sections are remarks, with the error that the odometry claims over them.
DriveDoubt drive_doubt(const session::Session& session, const back_end::BackEnd& back_end,
                       const KeyFramePoses& poses);

/// Writes the file doubt.csv of a session (doc/session.md). Throws FileError.
void write_doubt(const DriveDoubt& doubt, const std::filesystem::path& path);
/// Reads it. Throws FileError if it is missing, and InputError for contents that write_doubt() does
/// not write.
DriveDoubt read_doubt(const std::filesystem::path& path);

/// Messages for people: a sentence for each of the worst sections that are not trusted, and one
/// with the number of the others. Empty if the whole map can be trusted.
std::vector<std::string> warnings(const DriveDoubt& doubt);
/// A sentence on the remarks, which may be worth a look; empty if there are none.
std::string remark(const DriveDoubt& doubt);

}  // namespace lidar_mapping::pipeline
