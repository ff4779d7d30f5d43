// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "database.hpp"

namespace lidar_mapping::session {

/// Creates the tables of an empty database.
void create_tables(Database& database);
/// True if the database has no tables, because its process was killed before it created them.
bool is_empty(const Database& database);

/// Upgrades a database of an older version.
void upgrade_tables(Database& database);
/// False for an older version that was opened for reading.
bool has_loop_decisions(const Database& database);
/// The columns to select from the table scans, with "not known" for columns that an older version
/// does not have.
std::string columns_of_scans(const Database& database);
/// The same for the table key_frames.
std::string columns_of_key_frames(const Database& database);
/// The same for the table odometry.
std::string columns_of_odometry(const Database& database);

/// Throws FileError if the database is not a session, or if its version is newer than this package.
void check_tables(const Database& database, const std::filesystem::path& path);

}  // namespace lidar_mapping::session
