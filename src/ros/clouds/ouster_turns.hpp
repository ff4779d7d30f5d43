// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/ouster_packets.hpp"
#include "lidar_mapping/ros/byte_range.hpp"

#include "clouds/ouster_clock.hpp"

namespace lidar_mapping::ros_border {

/// A turn of an Ouster.
struct OusterTurn {
  Stamp recorded = 0;  ///< when its last packet was, as a driver would publish it
  /// x y z reflectivity as floats and t, ns from the first point, in the driver's frame os_lidar;
  /// header.seq is the sensor's number of the turn.
  sensor_msgs::PointCloud2 cloud;
};

/// Joins the packets of an Ouster to turns.
class OusterTurns {
 public:
  explicit OusterTurns(preprocessing::OusterDecoder decoder);

  const preprocessing::OusterDecoder& decoder() const { return decoder_; }

  /// Takes a packet; gives the turn before if a new one begins with it. A first turn that does not
  /// begin with its first column is left out, as recordings begin anywhere; so is a late packet,
  /// whose turn was given out before. Throws InputError for a packet of another size.
  std::optional<OusterTurn> add(ByteRange packet, Stamp recorded, const OusterClock& clock);
  /// The last turn, if it has its last column.
  std::optional<OusterTurn> finish(const OusterClock& clock);

  /// Number of packets of the turn so far, which was not given out.
  std::size_t packets_so_far() const { return packets_; }
  /// Number of packets that were left out because they came late.
  std::size_t late_packets() const { return late_packets_; }

 private:
  bool is_late(std::uint16_t frame) const;
  std::optional<OusterTurn> take(const OusterClock& clock);

  preprocessing::OusterDecoder decoder_;
  std::vector<preprocessing::OusterPoint> points_;  ///< of the turn so far
  std::optional<std::uint16_t> frame_;              ///< number of the turn
  Stamp recorded_ = 0;                              ///< when its last packet was
  bool is_first_ = true;                            ///< no turn was begun before it
  bool has_begin_ = false;                          ///< it has its first column
  bool has_end_ = false;                            ///< it has its last column
  bool is_given_ = false;                           ///< it was given out by finish()
  std::size_t packets_ = 0;                         ///< of the turn so far
  std::size_t late_packets_ = 0;                    ///< left out
};

}  // namespace lidar_mapping::ros_border
