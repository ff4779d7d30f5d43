// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/byte_range.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"

namespace lidar_mapping::ros_border {

/// Numbers of packets with points of an Ouster that are in no cloud, by their reasons.
struct OusterLosses {
  std::size_t without_metadata = 0;  ///< came too long before the metadata
  std::size_t damaged = 0;           ///< of another size than the metadata say, or cut off
  std::size_t late = 0;              ///< came when their turn had been given out
  /// Of a last turn whose end has not come, also of the last one before other metadata.
  std::size_t unfinished = 0;

  /// All of them.
  std::size_t total() const { return without_metadata + damaged + late + unfinished; }
};

/// Clouds and IMU samples of the packets that the driver of an Ouster publishes, as OusterTopics
/// makes them of recorded ones, but while they come: the metadata may come behind the first
/// packets, and the sensor's clock is known only as far as the packets have come. One thread calls
/// it.
class OusterFeed {
 public:
  /// Without metadata.
  OusterFeed();
  ~OusterFeed();

  /// Takes the text on the driver's topic of metadata, also another one later. Gives the clouds of
  /// the packets that have waited for it, and the turn before another one if its end has come.
  /// Throws InputError if it cannot be used.
  std::vector<RecordedCloud> set_metadata(const std::string& metadata);
  /// Whether usable metadata have come.
  bool has_metadata() const;

  /// Takes a serialised message with a packet of points, which came at this time of ROS, ns; gives
  /// the cloud that is complete with it. Packets of two seconds wait for the metadata. Throws
  /// InputError for a damaged packet.
  std::optional<RecordedCloud> add_points(ByteRange message, Stamp received);
  /// The sample in a serialised message with a packet of the IMU, which came at this time of ROS,
  /// ns. Throws InputError for a damaged packet.
  sensor_msgs::Imu imu_in(ByteRange message, Stamp received);
  /// The last turn, when no packet has come for a while; nothing if its end has not come.
  std::optional<RecordedCloud> finish();

  /// What is in no cloud so far.
  const OusterLosses& losses() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidar_mapping::ros_border
