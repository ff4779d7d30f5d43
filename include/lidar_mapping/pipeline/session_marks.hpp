// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/common/drive_marks.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// What a session knows of the path of the vehicle, its loops, and the sections of doubt.csv.
/// `poses` places the key frames; those that it does not hold are left out, and loops with them.
/// Throws FileError, and InputError for a doubt.csv that cannot be read; a session without one has
/// no doubtful sections.
DriveMarks session_marks(const session::Session& session, const KeyFramePoses& poses);

}  // namespace lidar_mapping::pipeline
