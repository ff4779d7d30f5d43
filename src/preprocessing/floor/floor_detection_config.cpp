// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/floor_detection_config.hpp"

namespace lidar_mapping::preprocessing {

const config::Schema<FloorDetectionConfig>& FloorDetectionConfig::schema() {
  using Config = FloorDetectionConfig;
  static const auto schema =
      config::Schema<Config>("floor_detection", "Detection of the floor below the vehicle.")
          .angle("tilt_deg", &Config::tilt, {-90.0, 90.0}, "deg",
                 "Rotation of the clouds about y that makes the floor level.")
          .real("sensor_height", &Config::sensor_height, {-10.0, 100.0}, "m",
                "Height above the floor of the origin of base_link, in which the clouds are.")
          .real("height_clip_range", &Config::height_clip_range, {0.01, 10.0}, "m",
                "Points this much above and below the expected floor are looked at.")
          .real("floor_radius", &Config::floor_radius, {1.0, 1000.0}, "m",
                "Points this near are looked at: farther off the ground is another plane.")
          .integer("floor_pts_thresh", &Config::floor_pts_thresh, {10, 1000000}, "points",
                   "Least number of points on the plane, of the strip that the vehicle drives on.")
          .angle("floor_normal_thresh", &Config::floor_normal_thresh, {0.1, 90.0}, "deg",
                 "A floor leans at most this much.")
          .real("floor_distance_thresh", &Config::floor_distance_thresh, {0.001, 1.0}, "m",
                "Points this near to a plane belong to it (RANSAC).")
          .boolean("use_normal_filtering", &Config::use_normal_filtering,
                   "Leave out places whose own surface is not level.")
          .angle("normal_filter_thresh", &Config::normal_filter_thresh, {0.1, 90.0}, "deg",
                 "Places leaning more are no floor.");
  return schema;
}

}  // namespace lidar_mapping::preprocessing
