// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace lidar_mapping {

/// Header of a PCD file (version 0.7) with x y z intensity as floats. Behind a "binary" one come
/// that many Points as they are in memory.
std::string pcd_header(std::size_t points, const std::string& data = "binary");

/// A field of the points of a PCD file.
struct PcdField {
  std::string name;       ///< as in FIELDS: x, intensity, ...
  std::size_t size = 0;   ///< bytes of one number
  char type = 'F';        ///< F, U or I: floating, unsigned or signed
  std::size_t count = 1;  ///< of numbers
};

/// What stands before the points of a PCD file.
struct PcdHeader {
  std::string text;              ///< all of it, with the line end behind DATA
  std::vector<PcdField> fields;  ///< in the order of the file
  std::size_t points = 0;        ///< their number
  std::size_t width = 0;         ///< points of a row
  std::string data;              ///< ascii, binary or binary_compressed

  /// Bytes of a point.
  std::size_t step() const;
  /// Whether x, y and z are there as floats.
  bool has_float_coordinates() const;
  /// Whether there is more than x y z intensity.
  bool has_more_fields() const;
};

/// Reads the header and checks it against the file: each line occurs once, in the format's order,
/// with as many words as there are fields; there are WIDTH times HEIGHT points; the file is long
/// enough for them. PCL's reader does not check this and writes beyond its memory if it is wrong,
/// so only files that pass are given to it. Throws FileError with the line.
PcdHeader read_pcd_header(const std::filesystem::path& path);

}  // namespace lidar_mapping
