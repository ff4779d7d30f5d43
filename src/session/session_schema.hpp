// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "database.hpp"

namespace lidar_mapping::session {

/// Makes the tables of an empty database.
void create_tables(Database& database);
/// True for one whose maker was killed before it had tables.
bool is_empty(const Database& database);

/// Brings a database of an older version up to date.
void upgrade_tables(Database& database);
/// False in an older version that was opened for reading.
bool has_loop_decisions(const Database& database);
/// What to select of the table scans, with "not known" for what an older version lacks.
std::string columns_of_scans(const Database& database);
/// And of the table key_frames.
std::string columns_of_key_frames(const Database& database);

/// Throws FileError if the database is no session or one of a newer version of this package.
void check_tables(const Database& database, const std::filesystem::path& path);

}  // namespace lidar_mapping::session
