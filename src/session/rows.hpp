// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/session.hpp"

#include "database.hpp"

namespace lidar_mapping::session {

// Conversions between values and the cells of a row, in the order of the columns of the table. Rows
// of loops and verdicts begin with an id, which reading skips. The decision of a person follows a
// loop.
Cells to_cells(const KeyFrame& key_frame);
Cells to_cells(const Loop& loop);
Cells to_cells(const LoopVerdict& verdict);
Cells to_cells(const GnssPosition& position);
Cells to_cells(const ImuSample& sample);
Cells to_cells(const Floor& floor);
Cells to_cells(const ScanRecord& scan);
Cells to_cells(const RevisionRecord& record);

KeyFrame read_key_frame(Statement& row);
Loop read_loop(Statement& row);
LoopVerdict read_verdict(Statement& row);
GnssPosition read_gnss(Statement& row);
ImuSample read_imu(Statement& row);
Floor read_floor(Statement& row);
ScanRecord read_scan(Statement& row);
std::pair<Stamp, Pose> read_odometry(Statement& row);
KeyFramePose read_pose(Statement& row);
RevisionRecord read_revision(Statement& row);

}  // namespace lidar_mapping::session
