// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "lidar_mapping/preprocessing/preprocessor.hpp"

namespace lidar_mapping::recordings {

/// A scan from a PCD file with the fields of any driver, by the rules of ros_border::decode():
/// times of the points and intensities under their usual names. Throws FileError or InputError.
preprocessing::RawScan read_pcd_scan(const std::string& path, Stamp stamp,
                                     const preprocessing::PreprocessingConfig& config);

}  // namespace lidar_mapping::recordings
