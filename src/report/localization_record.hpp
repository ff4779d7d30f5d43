// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::report {

/// What distinguishes a map from others, and from earlier states of itself.
struct MapIdentity {
  std::string session;         ///< name of its folder; a copy may have another one
  std::size_t key_frames = 0;  ///< number of those with a pose
  std::string digest;          ///< of their indices and stamps
  std::string pose_digest;     ///< of their poses
};

/// `map` holds the newest poses of the session in the folder `session`.
MapIdentity identity_of(const KeyFramePoses& map, const std::filesystem::path& session);

/// Why a map is not the one in which a drive was localised, in words; empty if it is.
std::string map_difference(const MapIdentity& localized_in, const MapIdentity& given);

/// Which drive was localised in which map: localization.json in the folder of localize_bag.
struct LocalizationRecord {
  std::vector<std::string> recordings;  ///< names of bags or folders of scans, without path
  MapIdentity map;
};

/// Names of recordings without their paths.
std::vector<std::string> names_of_recordings(const std::vector<std::string>& paths);

/// Throws FileError if the folder has no such file, and InputError naming it if it is damaged.
LocalizationRecord read_localization_record(const std::filesystem::path& folder);
/// Throws FileError.
void write_localization_record(const std::filesystem::path& folder,
                               const LocalizationRecord& record);

}  // namespace lidar_mapping::report
