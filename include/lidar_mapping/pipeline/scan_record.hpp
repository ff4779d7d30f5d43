// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// What the session keeps of the front end's status of a scan. Computing times are left out,
/// because they differ from run to run.
session::ScanRecord record_of(const front_end::FrontEndResult& result);

}  // namespace lidar_mapping::pipeline
