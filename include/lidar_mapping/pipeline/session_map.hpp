// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lidar_mapping/localization/map_index.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// A session as a finished map in which drives are localised (doc/localization.md). The session is
/// only read. One thread at a time uses it.
class SessionMap {
 public:
  /// Opens the session, or `latest` in the folder, and reads all clouds of its key frames by at
  /// most `threads` threads (0: all cores). Throws FileError, and InputError if the session has no
  /// optimised poses or no clouds.
  SessionMap(const std::filesystem::path& folder,
             const loop_closing::LoopClosingConfig& verification, int threads);

  /// The map for localization::Localizer, which must not outlive this object.
  localization::MapIndex& index() { return index_; }
  /// Geodetic origin of the map, which is then East-North-Up; none without GNSS, unless the map was
  /// imported with a datum.
  std::optional<GeodeticDatum> datum() const;
  /// Newest poses of the key frames, T_map_base.
  KeyFramePoses poses() const { return session_.poses(); }
  /// The points of all key frames in the map, one for each voxel of edge `resolution` (m, more
  /// than 0); for display.
  PointCloud cloud(double resolution) const;
  /// How large it is, for people: "12 places, 3400 Gaussians, tables of 5 MB". Places whose cloud
  /// is missing or damaged are named behind those that there are: "12 places, 3 of them without
  /// cloud".
  std::string size_text() const;
  /// Folder of the session.
  const std::filesystem::path& directory() const { return session_.directory(); }

 private:
  session::Session session_;
  localization::MapIndex index_;
};

}  // namespace lidar_mapping::pipeline
