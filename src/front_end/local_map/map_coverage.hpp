// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidar_mapping::front_end {

/// How complete a local map is.
struct MapCoverage {
  /// Up to this number of scans, the drift variance is increased: half of kWantedInsertions of
  /// delayed_initialization.cpp, with which planes are upright.
  static constexpr int kFewScans = 12;

  int inserted_scans = 0;
  /// True while all scans of the map were taken at about the same place.
  bool is_single_place = true;

  /// True while the map consists of few scans: see initial_drift_variance_factor().
  bool has_few_scans() const { return inserted_scans <= kFewScans; }
};

}  // namespace lidar_mapping::front_end
