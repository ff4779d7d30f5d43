// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/preprocessing/preprocessing_config.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/preprocessing/scan_pass.hpp"

namespace lidar_mapping::preprocessing {

/// Appends those points of another LiDAR's scan to a scan that were measured between its first and
/// last point, in its frame and with times relative to its stamp. Points that are out of the range
/// of the limits from the other LiDAR are left out, as rays without a return. Returns their number:
/// 0 if one of the scans has no times, or they do not overlap. The scan is unpacked; the other one
/// has to be. The fingerprint stays that of the scan's own points.
std::size_t append_points(RawScan& scan, const RawScan& other, const Pose& T_scan_other,
                          const PassLimits& limits);

/// How far apart the stamps of scans with points of the same time may be, s: one stamped at its
/// beginning and one at its end, each a turn.
inline double merging_reach(double scan_period) { return 2.0 * scan_period; }

/// Merges the scans of other LiDARs on the vehicle into those of the main one, as they come. A scan
/// waits for the next one of the main LiDAR, but only while another LiDAR sends scans of its time.
/// One thread calls it.
class ScanMerger {
 public:
  /// The scan period and the range of the configuration are those of all LiDARs.
  explicit ScanMerger(const PreprocessingConfig& config)
      : reach_(from_seconds(merging_reach(config.scan_period))), limits_(config) {}

  /// Whether there was a scan of another LiDAR.
  bool has_others() const { return !others_.empty(); }

  /// A scan of another LiDAR, known by its frame, whose place is T_base_other. It has to be
  /// unpacked.
  void add_other(RawScan scan, const Pose& T_base_other);
  /// A scan of the main LiDAR; the scans that are complete with it, oldest first.
  std::vector<RawScan> add(RawScan scan, const Pose& T_base_scan);
  /// The scan that still waits: for the end of the data.
  std::optional<RawScan> flush();

 private:
  struct PlacedScan {
    RawScan scan;
    Pose T_base_scan;
  };

  bool is_accompanied(Stamp scan) const;

  Stamp reach_;
  PassLimits limits_;
  std::map<std::string, std::deque<PlacedScan>> others_;  ///< by their frames, stamps rise
  std::optional<PlacedScan> held_;
};

}  // namespace lidar_mapping::preprocessing
