// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "lidar_mapping/common/utm.hpp"

namespace lidar_mapping::map {

constexpr double kMillimetre = 0.001;  // m; chosen: whole millimetres hold 2000 km in 32 bits

/// Coordinates of the map frame in whole millimetres of a file: of the UTM zone of the datum, whose
/// heights are above the ellipsoid, or of the map frame. They count from an offset in m.
class MillimetreFrame {
 public:
  explicit MillimetreFrame(const std::optional<GeodeticDatum>& datum);

  /// Easting, northing, height, or the position in the map frame; m.
  Eigen::Vector3d projected(const Eigen::Vector3d& p_map) const {
    return utm_ ? utm_->from_enu(p_map) : p_map;
  }
  /// Whole millimetres reach 2147 km from the offset: without a datum it follows from the first
  /// point of the map.
  void set_offset_near(const Eigen::Vector3d& p_map);
  /// What projected() gives, in millimetres from the offset. Throws InputError for a point that is
  /// too far from it.
  std::array<std::int32_t, 3> millimetres(const Eigen::Vector3d& p_projected) const;
  /// Where a reader of the file finds these millimetres, in m.
  Eigen::Vector3d position_of(const std::array<std::int32_t, 3>& millimetres) const {
    return offset_ + kMillimetre * Eigen::Vector3d(millimetres[0], millimetres[1], millimetres[2]);
  }
  const Eigen::Vector3d& offset() const { return offset_; }
  /// Code of WGS 84 / UTM (near the poles UPS); 0 without a datum.
  std::uint16_t epsg() const { return utm_ ? utm_->epsg() : std::uint16_t{0}; }

 private:
  std::optional<UtmFrame> utm_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
};

}  // namespace lidar_mapping::map
