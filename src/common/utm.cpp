// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/utm.hpp"

#include <string>

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping {

namespace {

/// m, by the definition of UTM: the northing of the equator for the southern half; for the northern
/// half it is zero.
constexpr double kFalseNorthing = 1e7;

}  // namespace

struct UtmFrame::Impl {
  explicit Impl(const GeodeticDatum& datum)
      : local(datum.latitude_deg, datum.longitude_deg, datum.altitude_m) {
    GeographicLib::UTMUPS::Forward(datum.latitude_deg, datum.longitude_deg, zone, north, origin.x(),
                                   origin.y());
    origin.z() = datum.altitude_m;
  }

  GeographicLib::LocalCartesian local;
  int zone = 0;  ///< 0 of UPS
  bool north = true;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};

UtmFrame::UtmFrame(const GeodeticDatum& datum) : impl_(std::make_shared<const Impl>(datum)) {}

Eigen::Vector3d UtmFrame::from_enu(const Eigen::Vector3d& p_enu) const {
  double latitude = 0.0;
  double longitude = 0.0;
  Eigen::Vector3d p;
  impl_->local.Reverse(p_enu.x(), p_enu.y(), p_enu.z(), latitude, longitude, p.z());
  int zone = 0;
  bool north = true;
  GeographicLib::UTMUPS::Forward(latitude, longitude, zone, north, p.x(), p.y(), impl_->zone);
  if (impl_->zone > 0 && north != impl_->north) {
    p.y() += impl_->north ? -kFalseNorthing : kFalseNorthing;
  }
  return p;
}

Eigen::Vector3d UtmFrame::to_enu(const Eigen::Vector3d& p_utm) const {
  double latitude = 0.0;
  double longitude = 0.0;
  try {
    GeographicLib::UTMUPS::Reverse(impl_->zone, impl_->north, p_utm.x(), p_utm.y(), latitude,
                                   longitude);
  } catch (const GeographicLib::GeographicErr& error) {
    throw InputError(std::string("the position is no place of the UTM zone: ") + error.what());
  }
  Eigen::Vector3d p;
  impl_->local.Forward(latitude, longitude, p_utm.z(), p.x(), p.y(), p.z());
  return p;
}

const Eigen::Vector3d& UtmFrame::origin() const { return impl_->origin; }

std::uint16_t UtmFrame::epsg() const {
  constexpr int kPolar = 61;  // by EPSG, which counts UPS as one more zone
  const int zone = impl_->zone > 0 ? impl_->zone : kPolar;
  return static_cast<std::uint16_t>((impl_->north ? 32600 : 32700) + zone);
}

}  // namespace lidar_mapping
