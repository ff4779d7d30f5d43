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

class UtmFrame::Impl {
 public:
  explicit Impl(const GeodeticDatum& datum)
      : local_(datum.latitude_deg, datum.longitude_deg, datum.altitude_m) {
    GeographicLib::UTMUPS::Forward(datum.latitude_deg, datum.longitude_deg, zone_, north_,
                                   origin_.x(), origin_.y());
    origin_.z() = datum.altitude_m;
  }

  Eigen::Vector3d from_enu(const Eigen::Vector3d& p_enu) const {
    double latitude = 0.0;
    double longitude = 0.0;
    Eigen::Vector3d p;
    local_.Reverse(p_enu.x(), p_enu.y(), p_enu.z(), latitude, longitude, p.z());
    int zone = 0;
    bool north = true;
    GeographicLib::UTMUPS::Forward(latitude, longitude, zone, north, p.x(), p.y(), zone_);
    if (zone_ > 0 && north != north_) p.y() += north_ ? -kFalseNorthing : kFalseNorthing;
    return p;
  }

  Eigen::Vector3d to_enu(const Eigen::Vector3d& p_utm) const {
    double latitude = 0.0;
    double longitude = 0.0;
    try {
      GeographicLib::UTMUPS::Reverse(zone_, north_, p_utm.x(), p_utm.y(), latitude, longitude);
    } catch (const GeographicLib::GeographicErr& error) {
      throw InputError(std::string("the position is no place of the UTM zone: ") + error.what());
    }
    Eigen::Vector3d p;
    local_.Forward(latitude, longitude, p_utm.z(), p.x(), p.y(), p.z());
    return p;
  }

  const Eigen::Vector3d& origin() const { return origin_; }

  std::uint16_t epsg() const {
    constexpr int kPolar = 61;  // by EPSG, which counts UPS as one more zone
    return static_cast<std::uint16_t>((north_ ? 32600 : 32700) + (zone_ > 0 ? zone_ : kPolar));
  }

 private:
  GeographicLib::LocalCartesian local_;
  int zone_ = 0;
  bool north_ = true;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
};

UtmFrame::UtmFrame(const GeodeticDatum& datum) : impl_(std::make_shared<const Impl>(datum)) {}

Eigen::Vector3d UtmFrame::from_enu(const Eigen::Vector3d& p_enu) const {
  return impl_->from_enu(p_enu);
}
Eigen::Vector3d UtmFrame::to_enu(const Eigen::Vector3d& p_utm) const {
  return impl_->to_enu(p_utm);
}
const Eigen::Vector3d& UtmFrame::origin() const { return impl_->origin(); }
std::uint16_t UtmFrame::epsg() const { return impl_->epsg(); }

}  // namespace lidar_mapping
