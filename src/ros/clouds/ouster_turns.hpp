// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/ouster_packets.hpp"
#include "lidar_mapping/ros/byte_range.hpp"

namespace lidar_mapping::ros_border {

/// How the clock of an Ouster stands to that of the recording.
struct OusterClock {
  Stamp begin = 0;     ///< by the sensor's clock, ns
  Stamp offset = 0;    ///< to be added to the sensor's time there, ns
  double drift = 0.0;  ///< change of the offset, s/s

  /// The time of ROS of a time of the sensor, ns. Throws InputError for one that is out of range.
  Stamp to_ros(Stamp sensor) const;
};

/// A turn of an Ouster.
struct OusterTurn {
  Stamp recorded = 0;  ///< when its last packet was, as a driver would publish it
  /// x y z reflectivity as floats and t, ns from the first point, in the driver's frame os_lidar.
  sensor_msgs::PointCloud2 cloud;
};

/// Joins the packets of an Ouster to turns.
class OusterTurns {
 public:
  explicit OusterTurns(preprocessing::OusterDecoder decoder);

  const preprocessing::OusterDecoder& decoder() const { return decoder_; }

  /// Takes a packet; gives the turn before if a new one begins with it. A first turn that does not
  /// begin with its first column is left out, as recordings begin anywhere; so is a packet of the
  /// turn before that comes late. Throws InputError for a packet of another size.
  std::optional<OusterTurn> add(ByteRange packet, Stamp recorded, const OusterClock& clock);
  /// The last turn, if it has its last column.
  std::optional<OusterTurn> finish(const OusterClock& clock);

 private:
  std::optional<OusterTurn> take(const OusterClock& clock);

  preprocessing::OusterDecoder decoder_;
  std::vector<preprocessing::OusterPoint> points_;  ///< of the turn so far
  std::optional<std::uint16_t> frame_;              ///< number of the turn
  Stamp recorded_ = 0;                              ///< when its last packet was
  bool is_first_ = true;                            ///< no turn was begun before it
  bool has_begin_ = false;                          ///< it has its first column
  bool has_end_ = false;                            ///< it has its last column
};

}  // namespace lidar_mapping::ros_border
