// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/pipeline/tracking_summary.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Where the map of a drive is doubtful, and how far off it may be there.
struct DriveDoubt {
  Stamp begin = 0;                         ///< of the drive's first scan
  double way = 0.0;                        ///< of the whole drive, m
  std::vector<DoubtfulStretch> stretches;  ///< places in map

  /// False if any stretch is not to be relied on.
  bool is_trusted() const;
};

/// What the front end said of the scans, seen in the light of the whole graph:
/// - a lost stretch is not trusted if neither loops nor GNSS join what came before and after it;
/// - a degenerate one if the error that may have come in there exceeds allowed_error(): that of a
///   way that only the believed speed has told, as far as odometry, loops and GNSS leave it;
/// - all else is a remark, with the error that odometry claims over it.
DriveDoubt drive_doubt(const session::Session& session, const back_end::BackEnd& back_end,
                       const KeyFramePoses& poses);

/// The file doubt.csv of a session (doc/session.md). Reading throws FileError if it is not there,
/// and InputError for what write_doubt() has not written.
void write_doubt(const DriveDoubt& doubt, const std::filesystem::path& path);
DriveDoubt read_doubt(const std::filesystem::path& path);

/// For people: a sentence for each of the worst stretches that are not trusted, and for the others
/// how many there are. Empty where the map can be trusted.
std::vector<std::string> warnings(const DriveDoubt& doubt);
/// One sentence on what may be looked at; empty if there is nothing.
std::string remark(const DriveDoubt& doubt);

}  // namespace lidar_mapping::pipeline
