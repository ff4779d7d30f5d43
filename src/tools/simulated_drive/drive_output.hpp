// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::tools {

/// Faults of drivers and recordings.
enum class BagFault {
  kImuInG,            ///< accelerations in g
  kGyroInDegrees,     ///< rates in degrees/s
  kVelocityInKmh,     ///< speeds in km/h
  kNoPointTimes,      ///< clouds without the field `time`
  kDeskewedTwice,     ///< times with points that are compensated (DriveOptions::undistorted)
  kNoImuTransform,    ///< imu_link is not in /tf_static
  kNoTransforms,      ///< there is no /tf_static
  kNoStamps,          ///< the stamps of clouds are 0
  kStampInTheMiddle,  ///< stamps of the middle of the scan with times from its start
  kLeadingSlash,      ///< frame /velo_link
  kAntennaElsewhere,  ///< /tf_static has the antenna 1.5 m from its position
  kGnssLate,          ///< fixes stamped 50 ms late
  kGnssTooConfident   ///< variances a hundredth of the true ones
};
/// The faults by the names of --fault.
const std::map<std::string, BagFault>& bag_faults();

/// Streams of a bag, and their faults.
struct BagContent {
  bool lidar = true;
  bool imu = true;
  bool gnss = true;
  bool velocity = true;
  std::string second_lidar;  ///< one of simulation::lidar_names(); empty: there is none
  std::set<BagFault> faults;

  bool has(BagFault fault) const { return faults.count(fault) > 0; }
};

/// Calls `take` for every scan of the drive in order; `threads` of them are computed at a time.
void for_each_scan(const simulation::Drive& drive, int threads,
                   const std::function<void(std::size_t, const simulation::SimulatedScan&)>& take);

/// Writes a bag with KITTI's topics, ordered by the time at which a driver would deliver a message.
void write_bag(const simulation::Drive& drive, const std::string& path, const BagContent& content,
               int threads);

/// Writes velodyne/, point_times/ and labels/ (a file per scan), times.txt and poses.txt.
void write_folder(const simulation::Drive& drive, const std::string& path, int threads);

/// Writes T_map_base at each scan's stamp as a TUM file.
void write_truth(const simulation::Drive& drive, const std::string& path);

}  // namespace lidar_mapping::tools
