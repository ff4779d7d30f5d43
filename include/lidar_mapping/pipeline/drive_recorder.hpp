// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>

#include "lidar_mapping/pipeline/map_extender.hpp"
#include "lidar_mapping/pipeline/place_pairing.hpp"

namespace lidar_mapping::pipeline {

/// Records a drive that is localised in a map, so that it can extend the map. One thread calls it.
class DriveRecorder {
 public:
  /// `extender` is not null, and gets what is recorded.
  explicit DriveRecorder(std::shared_ptr<MapExtender> extender) : extender_(std::move(extender)) {}

  /// Adds T_odom_base of a scan.
  void add_odometry(Stamp stamp, const Pose& T_odom_base) {
    extender_->add_odometry(stamp, T_odom_base);
  }
  /// Adds what the front end says of a scan.
  void add_scan(const session::ScanRecord& scan) { extender_->add_scan(scan); }
  /// Adds the next key frame. Throws FileError.
  void add_key_frame(const RunKeyFrame& received) {
    pairing_.add(received);
    store_ready();
  }
  /// Adds what is claimed about the place of the next scan. Throws FileError.
  void add_place(const localization::LocalizationResult& place) {
    pairing_.add(place);
    store_ready();
  }
  /// The place that is claimed now was wrong, as a person says.
  void withdraw_place() {
    if (const auto found = pairing_.withdraw_place()) extender_->withdraw_places(*found);
  }

  /// What was recorded so far.
  const LocalizedDrive& drive() const { return extender_->drive(); }
  /// What writes it.
  std::shared_ptr<const MapExtender> extender() const { return extender_; }

 private:
  void store_ready() {
    for (const auto& [key_frame, place] : pairing_.take_ready()) {
      extender_->add_key_frame(key_frame, place);
    }
  }

  std::shared_ptr<MapExtender> extender_;
  PlacePairing pairing_;
};

}  // namespace lidar_mapping::pipeline
