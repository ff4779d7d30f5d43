// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <ros/node_handle.h>

#include "lidar_mapping/common/pose.hpp"
#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::ros_border {

/// Tells the other nodes the datum of the session in which a run goes on.
void store_session_datum(const GeodeticDatum& datum, const std::string& run_id,
                         const ros::NodeHandle& node);

/// From the East-North-Up axes of this drive to those of its session. They differ where the session
/// was begun by an earlier drive, whose datum it keeps.
class SessionFrame {
 public:
  explicit SessionFrame(const ros::NodeHandle& node) : node_(node) {}

  /// The datum of the drive, from the topic gnss_datum.
  void set_drive_datum(const GeodeticDatum& datum);
  /// To be called at the first key frame of a run: the front end makes none before a session that
  /// is resumed is known.
  void begin_run(const std::string& run_id);

  /// Pose of the drive's axes in those of the session; identity until both data are known.
  const Pose& T_session_drive() const { return T_session_drive_; }
  /// Datum of the session, or else that of the drive.
  const std::optional<GeodeticDatum>& datum() const { return session_ ? session_ : drive_; }

 private:
  void update();

  ros::NodeHandle node_;
  std::string run_id_;
  std::optional<GeodeticDatum> drive_, session_;
  Pose T_session_drive_;
};

}  // namespace lidar_mapping::ros_border
