// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/pipeline/map_extension.hpp"

namespace lidar_mapping::pipeline {

/// How a map was extended by a drive.
struct ExtensionReport {
  MapExtension extension;      ///< What was added to the map, and what was left out.
  std::size_t key_frames = 0;  ///< Number of key frames that were added.
  double largest_move = 0.0;   ///< How far the key frames of the map moved at most, m.

  /// Whether there is a new session.
  bool is_written() const { return !extension.stretches.empty(); }
};

/// Makes a new session of a map and of what a drive that was localised in it adds
/// (doc/localization.md). The key frames of the drive wait in a hidden folder beside the new
/// session, which the destructor removes. One thread at a time uses it.
class MapExtender {
 public:
  /// `map` is the folder of the session in which the drive is localised, which is only read.
  /// `session` is the folder of the new one, which must not exist or be empty. Throws FileError,
  /// and InputError if the graph of the map uses no loops.
  MapExtender(const std::filesystem::path& map, const std::filesystem::path& session);
  ~MapExtender();

  /// Adds the next scan of the drive: its final odometry, and what was claimed about its place in
  /// the map. Throws FileError.
  void add(const front_end::FrontEndResult& odometry,
           const localization::LocalizationResult& place);

  /// Writes the session if the drive has something new that is tied to the map. The graph is solved
  /// with the parameters of the map. To be called once, at the end. Throws FileError, and
  /// InputError if loops that are found meanwhile contradict the ties; nothing is written then.
  ExtensionReport write();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::pipeline
