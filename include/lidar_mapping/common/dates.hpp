// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>
#include <string>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping {

/// The instant in UTC to the second by ISO 8601, such as "2026-05-01T12:00:00Z".
std::string iso_date(Stamp stamp);

/// A time in the time zone of this computer as the name of a file or run, such as
/// "2026-05-01_12-00-00": such names sort by time.
std::string dated_name(std::time_t time);

/// The last instant of a day, a minute or a second in UTC by ISO 8601: "2026-05-01",
/// "2026-05-01T12:00" or "2026-05-01T12:00:00", each with or without "Z". Throws InputError for
/// anything else.
Stamp end_of_date(const std::string& text);

}  // namespace lidar_mapping
