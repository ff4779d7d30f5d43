// SPDX-License-Identifier: BSD-3-Clause
#include "files/millimetre_frame.hpp"

#include <cmath>
#include <limits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::map {

MillimetreFrame::MillimetreFrame(const std::optional<GeodeticDatum>& datum) {
  if (!datum) return;
  utm_.emplace(*datum);
  const Eigen::Vector3d& origin = utm_->origin();
  offset_ = {1000.0 * std::floor(origin.x() / 1000.0), 1000.0 * std::floor(origin.y() / 1000.0),
             std::floor(origin.z())};
}

void MillimetreFrame::set_offset_near(const Eigen::Vector3d& p_map) {
  if (!utm_) offset_ = 1000.0 * (p_map / 1000.0).array().floor();
}

std::array<std::int32_t, 3> MillimetreFrame::millimetres(const Eigen::Vector3d& p_projected) const {
  constexpr double kLimit = std::numeric_limits<std::int32_t>::max();
  std::array<std::int32_t, 3> result{};
  for (int i = 0; i < 3; ++i) {
    const double value = (p_projected[i] - offset_[i]) / kMillimetre;
    if (!(std::abs(value) < kLimit)) {
      throw InputError(
          formatted("a point of the map lies %g m from the others, which 32 bits "
                    "cannot hold in millimetres; leave it out with --crop",
                    value * kMillimetre));
    }
    result[i] = static_cast<std::int32_t>(std::lround(value));
  }
  return result;
}

}  // namespace lidar_mapping::map
