// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/bag_stream.hpp"
#include "lidar_mapping/ros/cloud_view.hpp"

namespace lidar_mapping::ros_border {

/// How the raw packets of a sensor lie in a message.
enum class PacketLayout {
  kNone,           ///< there are points instead
  kVelodyne,       ///< of velodyne_msgs/VelodyneScan
  kHesaiInPlaces,  ///< of a PandarScan with 1500 bytes for each packet
  kHesaiInSizes    ///< of a PandarScan with each packet behind its size
};

/// A cloud of any of cloud_types(), in the layout of a PointCloud2, or as packets of a sensor. The
/// data stay in the memory of the recording where that has them so.
struct RecordedCloud {
  sensor_msgs::PointCloud2 message;            ///< without the data
  ByteRange data;                              ///< of the message, or the packets
  std::shared_ptr<const void> memory;          ///< where the data lie
  PacketLayout packets = PacketLayout::kNone;  ///< of the data; packets have no fields

  /// Whether the data are packets, which CloudReader decodes.
  bool holds_packets() const { return packets != PacketLayout::kNone; }

  /// The cloud with its data; this object has to outlive the view.
  CloudView view() const { return {message, data.first, data.size}; }
};

/// The cloud in a serialised message of one of cloud_types(), whose data lie in `memory`. `md5sum`
/// is that of the type's definition. Throws ros::Exception if it is damaged, and InputError for
/// another type.
RecordedCloud read_cloud(const std::string& type, const std::string& md5sum, ByteRange data,
                         std::shared_ptr<const void> memory);
/// The cloud in a message of a recording; empty if it is of another type. Throws ros::Exception if
/// it is damaged.
std::optional<RecordedCloud> read_cloud(const BagMessage& recorded);

}  // namespace lidar_mapping::ros_border
