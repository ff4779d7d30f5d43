// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/pipeline/map_extension.hpp"

namespace lidar_mapping::pipeline {

/// Pairs the key frames of a drive with what was claimed about the places of their scans, by equal
/// stamps, whichever comes first. The drive begins with the first scan whose place was looked for;
/// runs of the front end are numbered one behind the other. One thread calls it.
class PlacePairing {
 public:
  /// Adds what is claimed about the place of the next scan; stamps increase.
  void add(const localization::LocalizationResult& place);
  /// Adds the next key frame. One whose stamp does not increase is left out.
  void add(const RunKeyFrame& received);
  /// The pairs that are complete, oldest first, with their clouds. A key frame whose scan was lost
  /// on its way comes as one whose place is searched for.
  std::vector<LocalizedKeyFrame> take_ready();
  /// The place that is claimed now was wrong: the scans since it was found count as searching.
  /// Returns the stamp of the first of these, from which on the pairs that were taken are wrong,
  /// too; none if no place is claimed now.
  std::optional<Stamp> withdraw_place();

 private:
  KeyFrame numbered(const RunKeyFrame& received);

  std::map<Stamp, localization::LocalizationResult> places_;  ///< Since the last pair.
  std::deque<KeyFrame> waiting_;
  std::optional<Stamp> begin_;  ///< Of the drive.
  Stamp newest_place_ = 0;
  std::optional<Stamp> found_;  ///< When the place that is claimed now was found.
  std::optional<Stamp> newest_key_frame_;
  std::string run_id_;
  KeyFrameIndex first_index_ = 0;  ///< Of this run in the drive.
  KeyFrameIndex next_index_ = 0;
  std::uint32_t first_segment_ = 0;  ///< Of this run in the drive.
  std::uint32_t next_segment_ = 0;
};

}  // namespace lidar_mapping::pipeline
