// SPDX-License-Identifier: BSD-3-Clause
// Builds the map of a session (what a drive leaves behind, doc/session.md) and writes its files.
//   map_of_session SESSION FOLDER [VOXEL_SIZE]

#include <cstdio>
#include <exception>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/map/write_products.hpp"
#include "lidar_mapping/session/session.hpp"

using namespace lidar_mapping;

int main(int argc, char** argv) try {
  if (argc < 3 || argc > 4) {
    throw InputError("usage: map_of_session SESSION FOLDER [VOXEL_SIZE]");
  }
  std::vector<config::Source> parameters;  // those that are not given have their defaults
  if (argc == 4) {
    parameters.push_back(config::parse_yaml(std::string("resolution: ") + argv[3], "command line"));
  }
  const auto config = config::load<map::MapConfig>(parameters);

  const auto session = session::Session::open(argv[1], session::Session::Access::kRead);
  const KeyFramePoses poses = session.poses();  // T_map_base of the newest optimisation

  map::ProductOptions options;
  options.formats = {"pcd", "las", "png"};
  options.datum = session.datum();                  // where the map lies on Earth, if GNSS told it
  options.p_base_sensor = session.sensor_origin();  // if known, moving objects are left out

  const map::Products products =
      map::write_products(poses, session.clouds(), config, options, argv[2]);
  std::printf("%zu points of %zu key frames\n", products.points, poses.poses.size());
  for (const auto& file : products.files) std::printf("%s\n", file.c_str());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
