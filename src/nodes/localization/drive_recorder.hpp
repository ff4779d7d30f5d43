// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>

#include "lidar_mapping/pipeline/map_extender.hpp"

#include "localization/place_pairing.hpp"

namespace lidar_mapping::ros_border {

/// Records a drive that is localised in a map, so that it can extend the map. One thread calls it.
class DriveRecorder {
 public:
  /// `extender` is not null, and gets what is recorded.
  explicit DriveRecorder(std::shared_ptr<pipeline::MapExtender> extender)
      : extender_(std::move(extender)) {}

  /// Adds T_odom_base of a scan.
  void add_odometry(Stamp stamp, const Pose& T_odom_base) {
    extender_->add_odometry(stamp, T_odom_base);
  }
  /// Adds what the front end says of a scan.
  void add_scan(const session::ScanRecord& scan) { extender_->add_scan(scan); }
  /// Adds the next key frame. Throws FileError.
  void add_key_frame(const RunKeyFrame& received);
  /// Adds what is claimed about the place of the next scan. Throws FileError.
  void add_place(const localization::LocalizationResult& place);
  /// The place that is claimed now was wrong, as a person says.
  void withdraw_place();

  /// What was recorded so far, and what writes it.
  const pipeline::LocalizedDrive& drive() const { return extender_->drive(); }
  std::shared_ptr<const pipeline::MapExtender> extender() const { return extender_; }

 private:
  void store_ready();

  std::shared_ptr<pipeline::MapExtender> extender_;
  PlacePairing pairing_;
};

}  // namespace lidar_mapping::ros_border
