// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace lidar_mapping {

// Names that drivers give to the fields of a point beside its coordinates, in messages and in PCD
// files. Every reader takes them from here alone. They are in lower case; in a cloud they may be of
// any case. Of several fields of a cloud the one whose name comes first is used.

/// Of the intensity of a point.
inline constexpr std::array kIntensityNames = {"intensity", "i", "reflectivity", "reflectance",
                                               "intensities"};
/// Of the time of a point. Times in two fields are found beside this list.
inline constexpr std::array kTimeNames = {
    "time",   "t",       "timestamp", "time_stamp",   "offset_time", "time_offset",    "ts",
    "stamp",  "time_ns", "t_ns",      "timestamp_ns", "time_us",     "time_offset_ns", "time_sec",
    "stamps", "usec",    "nsec"};

}  // namespace lidar_mapping
