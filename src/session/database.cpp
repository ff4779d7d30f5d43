// SPDX-License-Identifier: BSD-3-Clause
#include "database.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <system_error>

#include <sqlite3.h>
#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_words.hpp"

namespace lidar_mapping::session {

namespace {

constexpr int kBusyTimeoutMs = 5000;     // chosen: longer than writing a chunk takes
constexpr std::size_t kShownBytes = 40;  // of a damaged cell in a message; chosen: half a line
/// Limit for stored numbers. Chosen so that products of information and covariances do not
/// overflow.
constexpr double kMaxNumber = 1e100;

bool is_number(double value) { return std::abs(value) <= kMaxNumber; }
bool is_coordinate(double value) { return std::abs(value) <= kMaxCoordinate; }
bool is_rotation(const Eigen::Quaterniond& rotation) {
  constexpr double kNormTolerance = 0.5;  // chosen: only damage is to be found
  return std::abs(rotation.norm() - 1.0) < kNormTolerance;
}

[[noreturn]] void refuse(const std::string& what) {
  throw InputError(what + " cannot be stored in a session");
}

std::string name_of(sqlite3* database) {
  const char* file = sqlite3_db_filename(database, "main");
  return file != nullptr ? file : "session database";
}

[[noreturn]] void fail(sqlite3* database) {
  throw FileError(name_of(database) + ": " + sqlite3_errmsg(database));
}

void check(int code, sqlite3* database) {
  if (code != SQLITE_OK) fail(database);
}

/// A reader in WAL mode needs files beside the database. Where none can be made, the database is
/// read as it is, unless it has a log, which would be left out.
bool is_immutable(const std::filesystem::path& path) {
  const std::filesystem::path file = std::filesystem::absolute(path);
  std::error_code ignored;
  return ::access(file.parent_path().c_str(), W_OK) != 0 &&
         std::filesystem::is_regular_file(file, ignored) &&
         !std::filesystem::exists(file.string() + "-wal", ignored);
}

/// The address of a file that nobody changes, by SQLite's rules.
std::string immutable_uri(const std::filesystem::path& path) {
  std::string uri = "file://";
  for (const char letter : std::filesystem::absolute(path).string()) {
    if (letter == '%') {
      uri += "%25";
    } else if (letter == '?') {
      uri += "%3F";
    } else if (letter == '#') {
      uri += "%23";
    } else {
      uri += letter;
    }
  }
  return uri + "?immutable=1";
}

int flags_of(Database::Mode mode) {
  switch (mode) {
    case Database::Mode::kCreate:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    case Database::Mode::kWrite:
      return SQLITE_OPEN_READWRITE;
    case Database::Mode::kRead:
      return SQLITE_OPEN_READONLY;
  }
  return SQLITE_OPEN_READONLY;
}

}  // namespace

Statement::Statement(sqlite3* database, const std::string& sql, const Cells& values)
    : database_(database) {
  sqlite3_stmt* statement = nullptr;
  check(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr), database);
  statement_.reset(statement);
  for (std::size_t i = 0; i < values.size(); ++i) bind(static_cast<int>(i) + 1, values[i]);
}

void Statement::bind(int position, const Cell& value) {
  sqlite3_stmt* statement = statement_.get();
  int code = SQLITE_OK;
  if (std::holds_alternative<std::nullptr_t>(value)) {
    code = sqlite3_bind_null(statement, position);
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    code = sqlite3_bind_int64(statement, position, *integer);
  } else if (const auto* real = std::get_if<double>(&value)) {
    code = sqlite3_bind_double(statement, position, *real);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    code = sqlite3_bind_text(statement, position, text->data(), static_cast<int>(text->size()),
                             SQLITE_TRANSIENT);
  } else {
    const Blob& blob = std::get<Blob>(value);
    code = sqlite3_bind_blob(statement, position, blob.empty() ? nullptr : blob.data(),
                             static_cast<int>(blob.size() * sizeof(double)), SQLITE_TRANSIENT);
  }
  check(code, database_);
}

bool Statement::step() {
  column_ = 0;
  const int code = sqlite3_step(statement_.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail(database_);
  return code == SQLITE_ROW;
}

bool Statement::next_is_null() const { return type_of(column_) == SQLITE_NULL; }

/// Checks such as for a text in a column of numbers. Only damaged files fail them.
void Statement::require(bool is_sound, int column, const std::string& expected) const {
  if (is_sound) return;
  const auto* shown = sqlite3_column_text(statement_.get(), column);
  const std::string shown_text =
      shown == nullptr ? "nothing" : reinterpret_cast<const char*>(shown);
  throw FileError(name_of(database_) + ": a row has '" + shown_text.substr(0, kShownBytes) +
                  "' as " + sqlite3_column_name(statement_.get(), column) + " instead of " +
                  expected + "; the session is damaged");
}

int Statement::type_of(int column) const { return sqlite3_column_type(statement_.get(), column); }

std::int64_t Statement::read_integer(std::int64_t min_value, std::int64_t max_value) {
  const int column = column_++, type = type_of(column);
  const std::int64_t value = sqlite3_column_int64(statement_.get(), column);
  const bool is_integer = type == SQLITE_INTEGER || type == SQLITE_NULL;
  require(is_integer && value >= min_value && value <= max_value, column,
          "a whole number that can be");
  return value;
}

double Statement::read_real() {
  const int column = column_++, type = type_of(column);
  require(type != SQLITE_TEXT && type != SQLITE_BLOB, column, "a number");
  return sqlite3_column_double(statement_.get(), column);
}

double Statement::read_coordinate() {
  const int column = column_;
  const bool has_value = !next_is_null();
  const double value = read_real();
  require(has_value && is_coordinate(value), column, "a coordinate");
  return value;
}

std::string Statement::read_text() {
  const int column = column_++;
  const auto* text = sqlite3_column_text(statement_.get(), column);
  if (text == nullptr) return {};
  return {reinterpret_cast<const char*>(text),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

Blob Statement::read_blob() {
  const int column = column_++, type = type_of(column);
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const auto bytes = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  Blob blob(bytes / sizeof(double));
  if (!blob.empty()) std::memcpy(blob.data(), data, blob.size() * sizeof(double));
  const bool is_of_numbers = (type == SQLITE_BLOB || type == SQLITE_NULL) &&
                             bytes % sizeof(double) == 0 &&
                             std::all_of(blob.begin(), blob.end(), is_number);
  require(is_of_numbers, column, "finite numbers");
  return blob;
}

Blob Statement::read_blob(std::size_t size) {
  const int column = column_;
  Blob blob = read_blob();
  require(blob.empty() || blob.size() == size, column, std::to_string(size) + " numbers");
  blob.resize(size, 0.0);
  return blob;
}

Eigen::Vector3d Statement::read_vector() {
  const double x = read_coordinate();
  const double y = read_coordinate();
  const double z = read_coordinate();
  return {x, y, z};
}

Eigen::Quaterniond Statement::read_quaternion() {
  const int column = column_;
  const Eigen::Vector3d xyz = read_vector();
  const Eigen::Quaterniond rotation(read_coordinate(), xyz.x(), xyz.y(), xyz.z());
  require(is_rotation(rotation), column, "a quaternion of unit length");
  return rotation;
}

Pose Statement::read_pose() {
  Pose pose;
  pose.translation = read_vector();
  pose.rotation = read_quaternion();
  return pose;
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Database::Database(const std::filesystem::path& path, Mode mode) {
  const bool immutable = mode == Mode::kRead && is_immutable(path);
  const std::string name = immutable ? immutable_uri(path) : path.string();
  const int flags = immutable ? flags_of(mode) | SQLITE_OPEN_URI : flags_of(mode);
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &database, flags, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK) {
    throw FileError("cannot open " + path.string() + ": " + sqlite3_errmsg(database));
  }
  check(sqlite3_busy_timeout(database, kBusyTimeoutMs), database);
  if (mode == Mode::kRead) return;
  execute("PRAGMA journal_mode = WAL");
  execute("PRAGMA synchronous = NORMAL");
}

void Database::execute(const std::string& sql) {
  check(sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr), database_.get());
}

void Database::run(const std::string& sql, const Cells& values) {
  Statement(database_.get(), sql, values).step();
}

Statement Database::query(const std::string& sql, const Cells& values) const {
  return {database_.get(), sql, values};
}

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Transaction::Transaction(Database& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (committed_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const std::exception&) {
    // SQLite has rolled back already, as it does if the disk is full.
  }
}

void Transaction::commit() {
  database_.execute("COMMIT");
  committed_ = true;
}

void append(Cells& cells, const Eigen::Vector3d& vector) {
  for (const double value : {vector.x(), vector.y(), vector.z()}) {
    if (!is_coordinate(value)) refuse("a coordinate of " + std::to_string(value));
    cells.emplace_back(value);
  }
}

void append(Cells& cells, const Eigen::Quaterniond& rotation) {
  if (!is_rotation(rotation)) {
    refuse("a quaternion of length " + std::to_string(rotation.norm()));
  }
  for (const double value : {rotation.x(), rotation.y(), rotation.z(), rotation.w()}) {
    cells.emplace_back(value);
  }
}

void append(Cells& cells, const Pose& pose) {
  append(cells, pose.translation);
  append(cells, pose.rotation);
}

void append(Cells& cells, const Blob& blob) {
  if (!std::all_of(blob.begin(), blob.end(), is_number)) {
    refuse("a matrix with a number that is not finite");
  }
  cells.emplace_back(blob);
}

}  // namespace lidar_mapping::session
