#pragma once

#include <functional>
#include <string>

#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::tools {

/// Which streams besides the LiDAR's go into a bag.
struct BagContent {
  bool imu = true;
  bool gnss = true;
  bool velocity = true;
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
