// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::city {

/// The appearance key of a place, rounded to bytes (in steps of 1/128).
using AppearanceKey =
    std::array<std::uint8_t, loop_closing::SpectrumDescriptor::Key::SizeAtCompileTime>;

/// Euclidean distance of two keys before rounding, without unit; 0 for the same view.
double distance_between(const AppearanceKey& a, const AppearanceKey& b);

/// A stretch of a drive, some hundred metres of one segment: what is paired with other drives.
struct Piece {
  KeyFrameIndex first = 0;  ///< its first key frame in the drive
  KeyFrameIndex last = 0;   ///< its last key frame in the drive
  /// Box around its GNSS positions, earth-centred and earth-fixed, m, taken at height 0: heights
  /// need not be known. Empty where there is no position.
  std::optional<Eigen::AlignedBox3d> box;
  std::vector<AppearanceKey> places;  ///< appearance every few metres
};

/// A drive in pieces: all that pairing needs, without clouds.
struct DrivePieces {
  std::string drive;          ///< name: that of the folder of the session
  std::vector<Piece> pieces;  ///< in the order of the drive
};

/// Cuts the drive of a session into pieces and describes them. Throws FileError.
DrivePieces describe_drive(const session::Session& session, const std::string& name);

}  // namespace lidar_mapping::city
