// SPDX-License-Identifier: BSD-3-Clause
// map_city is a script: its tests are in Python, as it is.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

TEST(MapCity, ReadsProjects) { EXPECT_EQ(std::system("python3 city/check_project.py"), 0); }

TEST(MapCity, RunsItsJobs) { EXPECT_EQ(std::system("python3 city/check_map_city.py"), 0); }

/// Three simulated drives and a bag that is none become a city, with one job and with two.
TEST(MapCity, MapsThreeDrives) {
  const std::string command =
      std::string("python3 city/check_three_drives.py ") + LIDAR_MAPPING_PROGRAMS;
  EXPECT_EQ(std::system(command.c_str()), 0);
}
