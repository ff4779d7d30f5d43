// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/simulation/drive.hpp"
#include "lidar_mapping/simulation/random.hpp"

namespace lidar_mapping::campaign {

/// A case of a campaign: a world, a motion, its sensors and their faults.
struct CampaignCase {
  std::string name;
  std::string drive = "town";
  std::string lidar;                  ///< empty: each one of the campaign
  std::optional<std::uint64_t> seed;  ///< none: each one of the campaign
  double start = 0.0;                 ///< s of the drive's beginning that are left out
  double scan_rate = 10.0;            ///< turns per second
  double range_noise = 0.02;          ///< m
  std::size_t every = 1;              ///< the front end gets every n-th scan only
  bool undistorted = false;
  std::string method = "NDT";       ///< registration_method
  std::string imu = "none";         ///< one of simulation::imu_names(), or none for the front end
  std::vector<std::string> faults;  ///< simulation::add_fault
};

/// From "NAME key=value key=value ...", keys as the fields' names; `fault=outliers=0.15` may come
/// several times. Throws ConfigError.
CampaignCase parse_case(const std::string& line);
/// The drive of a case that has a sensor and a seed, cut after `duration` seconds from its start.
simulation::DriveOptions drive_options(const CampaignCase& campaign_case, double duration);
/// A line of that form.
std::string to_line(const CampaignCase& campaign_case);
/// One case per line; empty lines and those that begin with # are left out. Throws FileError or
/// ConfigError with the number of the line.
std::vector<CampaignCase> read_cases(const std::string& path);

/// What the documentation's table has: each fault alone.
std::vector<CampaignCase> usual_cases();
/// A random mixture of world, sensor, motion and faults.
CampaignCase random_case(simulation::Random& random);

}  // namespace lidar_mapping::campaign
