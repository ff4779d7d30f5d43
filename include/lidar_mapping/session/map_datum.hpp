// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/imported_map.hpp"

namespace lidar_mapping::session {

/// Geodetic origin of the frame in which the newest stored poses lie; empty if that is not known,
/// or if they do not lie in East-North-Up: the session has a datum as soon as one position of GNSS
/// was received, be the poses aligned to these or not. The poses of an older session, which did not
/// keep it, count as aligned. Throws FileError.
inline std::optional<GeodeticDatum> map_datum(const Session& session) {
  const std::optional<GeodeticDatum> datum = session.datum();
  // An imported map lies in its datum's frame without any position.
  if (!datum || is_imported_map(session)) return datum;
  const bool in_enu = session.poses_in_enu().value_or(!session.poses().poses.empty());
  return in_enu ? datum : std::nullopt;
}

}  // namespace lidar_mapping::session
