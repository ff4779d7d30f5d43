// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "lidar_mapping/back_end/back_end_config.hpp"
#include "lidar_mapping/pipeline/map_extension.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// A drive that is localised in a map, as far as it has come.
struct LocalizedDrive {
  std::vector<LocalizedKeyFrame> key_frames;     ///< By increasing index and stamp.
  std::vector<session::ScanRecord> scans;        ///< What the front end says of its scans.
  std::vector<std::pair<Stamp, Pose>> odometry;  ///< T_odom_base of its scans.
};

/// How a map was extended by a drive.
struct ExtensionReport {
  MapExtension extension;      ///< What was added to the map, and what was left out.
  std::size_t key_frames = 0;  ///< Number of key frames that were added.
  double largest_move = 0.0;   ///< How far the key frames of the map moved at most, m.

  /// Whether there is a new session.
  bool is_written() const { return !extension.sections.empty(); }
};

/// A hidden folder beside a session that is to be written, for the clouds of a MapExtender: they
/// can be linked from there.
std::filesystem::path folder_beside(const std::filesystem::path& session);

/// Collects a drive that is localised in a map, and makes a new session of the map and of what the
/// drive adds to it (doc/localization.md). One thread at a time uses it, but write() of a copy of
/// drive() may run beside it in one other thread, so that the drive goes on meanwhile.
class MapExtender {
 public:
  /// `map` is the folder of the session in which the drive is localised, which is only read. The
  /// clouds of the drive wait in `folder`, which is made anew and removed by the destructor. Throws
  /// FileError, and InputError if the graph of the map uses no loops.
  MapExtender(const std::filesystem::path& map, const std::filesystem::path& folder);
  ~MapExtender();

  /// Adds what the front end says of a scan of the drive.
  void add_scan(const session::ScanRecord& scan) { drive_.scans.push_back(scan); }
  /// Adds T_odom_base of a scan of the drive.
  void add_odometry(Stamp stamp, const Pose& T_odom_base) {
    drive_.odometry.emplace_back(stamp, T_odom_base);
  }
  /// Adds the next key frame of the drive with its cloud, and what was claimed about the place of
  /// its scan. Indices and stamps increase. Throws FileError.
  void add_key_frame(const KeyFrame& key_frame, const localization::LocalizationResult& place);
  /// The places that were claimed since this stamp were wrong: the key frames from it on count as
  /// searching.
  void withdraw_places(Stamp since);

  /// All that was added, without clouds.
  const LocalizedDrive& drive() const { return drive_; }

  /// Writes the folder `session`, which must not exist or be empty, if the drive has something new
  /// that is tied to the map. `drive` is drive() or an earlier copy of it. The graph is solved with
  /// the parameters of the map. Throws FileError, and InputError if loops that are found meanwhile
  /// contradict the ties; nothing is written then.
  ExtensionReport write(const LocalizedDrive& drive, const std::filesystem::path& session) const;

 private:
  const std::filesystem::path map_;
  const back_end::BackEndConfig config_;
  const std::filesystem::path folder_;
  session::CloudStore clouds_;
  LocalizedDrive drive_;
};

}  // namespace lidar_mapping::pipeline
