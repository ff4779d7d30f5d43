// SPDX-License-Identifier: BSD-3-Clause
#include "session_schema.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::session {

namespace {

constexpr std::int64_t kApplicationId = 0x4C4D6170;  // chosen: "LMap" in ASCII
constexpr std::int64_t kVersion = 7;  // of the tables, by definition; grows whenever these change
// Older versions can be read, by the history of the format. They are upgraded when they are opened
// for writing.
constexpr std::int64_t kWithoutDecisions = 1;
constexpr std::int64_t kWithoutUnobserved = 2;
constexpr std::int64_t kWithoutElevation = 3;
constexpr std::int64_t kWithoutProbability = 4;
constexpr std::int64_t kWithoutDoubt = 5;
constexpr std::int64_t kWithoutDrive = 6;

// Stamps in ns, metres, radians; poses as x y z qx qy qz qw; covariances as blobs of doubles, row
// by row, in the order translation, rotation (axes of the child frame).
constexpr const char* kTables = R"sql(
CREATE TABLE properties (name TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE configurations (stage TEXT PRIMARY KEY, yaml TEXT) WITHOUT ROWID;
CREATE TABLE key_frames (
  key_frame INTEGER PRIMARY KEY, segment INTEGER, stamp INTEGER,
  x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL, qw REAL,
  motion_covariance BLOB, degenerate_directions BLOB, points INTEGER);
CREATE TABLE loops (
  id INTEGER PRIMARY KEY, from_key_frame INTEGER, to_key_frame INTEGER, stamp INTEGER,
  x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL, qw REAL,
  covariance BLOB, fitness REAL, overlap REAL, source TEXT,
  UNIQUE (from_key_frame, to_key_frame));
CREATE TABLE loop_verdicts (
  id INTEGER PRIMARY KEY, from_key_frame INTEGER, to_key_frame INTEGER, stamp INTEGER,
  source TEXT, verdict TEXT, reason TEXT, distance REAL, fitness REAL, overlap REAL,
  free_space_violation REAL, horizontal_eigenvalue REAL, innovation REAL);
CREATE TABLE gnss (
  stamp INTEGER PRIMARY KEY, x REAL, y REAL, z REAL, covariance BLOB,
  antenna_x REAL, antenna_y REAL, antenna_z REAL, qx REAL, qy REAL, qz REAL, qw REAL);
CREATE TABLE imu (
  stamp INTEGER PRIMARY KEY, wx REAL, wy REAL, wz REAL, ax REAL, ay REAL, az REAL,
  qx REAL, qy REAL, qz REAL, qw REAL);
CREATE TABLE floors (
  stamp INTEGER PRIMARY KEY, found INTEGER, nx REAL, ny REAL, nz REAL, offset REAL,
  covariance BLOB, inliers INTEGER);
CREATE TABLE scans (
  stamp INTEGER PRIMARY KEY, state TEXT, fitness REAL, overlap REAL, seconds REAL,
  scans_dropped INTEGER);
CREATE TABLE odometry (
  stamp INTEGER PRIMARY KEY,
  x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL, qw REAL);
CREATE TABLE poses (
  revision INTEGER, key_frame INTEGER, stamp INTEGER,
  x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL, qw REAL,
  PRIMARY KEY (revision, key_frame)) WITHOUT ROWID;
CREATE TABLE revisions (
  revision INTEGER PRIMARY KEY, key_frames INTEGER, loops_used INTEGER, loops_refused INTEGER,
  gnss_used INTEGER, gnss_refused INTEGER, cost_before REAL, cost_after REAL, seconds REAL);
)sql";

constexpr const char* kDecisions = R"sql(
CREATE TABLE loop_decisions (
  from_key_frame INTEGER, to_key_frame INTEGER, decision TEXT,
  PRIMARY KEY (from_key_frame, to_key_frame)) WITHOUT ROWID;
)sql";

std::int64_t pragma(const Database& database, const std::string& name) {
  Statement row = database.query("PRAGMA " + name);
  return row.step() ? row.read_integer() : 0;
}

/// From version 2 to 3.
constexpr const char* kUnobserved =
    "ALTER TABLE scans ADD COLUMN unobserved_stddev REAL DEFAULT 0.0";

/// From version 3 to 4.
constexpr const char* kElevation = "ALTER TABLE scans ADD COLUMN elevation_shift REAL DEFAULT 0.0";

/// From version 4 to 5.
constexpr const char* kProbability = "ALTER TABLE scans ADD COLUMN probability REAL DEFAULT -1.0";

/// From version 5 to 6.
constexpr const char* kDoubt = "ALTER TABLE key_frames ADD COLUMN doubtful INTEGER DEFAULT 0";

/// From version 6 to 7.
constexpr const char* kDrive = "ALTER TABLE odometry ADD COLUMN drive INTEGER DEFAULT 0";

/// Upgrades the tables from a version to the newest one.
void migrate(Database& database, std::int64_t version) {
  if (version <= kWithoutDecisions) database.execute(kDecisions);
  if (version <= kWithoutUnobserved) database.execute(kUnobserved);
  if (version <= kWithoutElevation) database.execute(kElevation);
  if (version <= kWithoutProbability) database.execute(kProbability);
  if (version <= kWithoutDoubt) database.execute(kDoubt);
  if (version <= kWithoutDrive) database.execute(kDrive);
  database.execute("PRAGMA user_version = " + std::to_string(kVersion));
}

}  // namespace

void create_tables(Database& database) {
  Transaction transaction(database);
  database.execute(kTables);
  database.execute("PRAGMA application_id = " + std::to_string(kApplicationId));
  migrate(database, kWithoutDecisions);
  transaction.commit();
}

bool is_empty(const Database& database) {
  return !database.query("SELECT 1 FROM sqlite_master").step();
}

void upgrade_tables(Database& database) {
  const std::int64_t version = pragma(database, "user_version");
  if (version == kVersion) return;
  Transaction transaction(database);
  migrate(database, version);
  transaction.commit();
}

bool has_loop_decisions(const Database& database) {
  return pragma(database, "user_version") > kWithoutDecisions;
}

std::string columns_of_scans(const Database& database) {
  const std::int64_t version = pragma(database, "user_version");
  std::string columns = "*";
  for (const std::int64_t without : {kWithoutUnobserved, kWithoutElevation}) {
    if (version <= without) columns += ", 0.0";
  }
  if (version <= kWithoutProbability) columns += ", -1.0";
  return columns;
}

std::string columns_of_key_frames(const Database& database) {
  return pragma(database, "user_version") <= kWithoutDoubt ? "*, 0" : "*";
}

std::string columns_of_odometry(const Database& database) {
  return pragma(database, "user_version") <= kWithoutDrive ? "*, 0" : "*";
}

void check_tables(const Database& database, const std::filesystem::path& path) {
  if (pragma(database, "application_id") != kApplicationId) {
    throw FileError(path.string() + " is no session of lidar_mapping");
  }
  const std::int64_t version = pragma(database, "user_version");
  if (version >= kWithoutDecisions && version <= kVersion) return;
  throw FileError(path.string() + " has version " + std::to_string(version) +
                  " of the session's tables, this program knows version " +
                  std::to_string(kVersion) + "; use the lidar_mapping that made it");
}

}  // namespace lidar_mapping::session
