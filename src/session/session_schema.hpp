#pragma once

#include "database.hpp"

namespace lidar_mapping::session {

/// Makes the tables of an empty database.
void create_tables(Database& database);

/// Throws FileError if the database is no session or one of a newer version of this package.
void check_tables(const Database& database, const std::filesystem::path& path);

}  // namespace lidar_mapping::session
