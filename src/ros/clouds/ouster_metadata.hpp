// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/preprocessing/ouster_packets.hpp"

namespace lidar_mapping::ros_border {

/// The format of an Ouster's packets, from the metadata (JSON) that its driver publishes, in the
/// layout of all firmware. Throws InputError for damaged or incomplete metadata, by the key.
preprocessing::OusterFormat ouster_format(const std::string& metadata);

}  // namespace lidar_mapping::ros_border
