// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/ros2_file.hpp"

#include <algorithm>

#include <sqlite3.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

#include "bags/cdr_message.hpp"
#include "bags/file_bytes.hpp"
#include "bags/ros2_types.hpp"

namespace lidar_mapping::ros_border {

namespace {

const std::string kSqlite = "SQLite format 3";      // how such a file begins
const std::string kZstandard = "\x28\xB5\x2F\xFD";  // how such a file begins

/// Latest time of ROS, ns: seconds of 32 bits, by definition. The database holds 64 bits, of which
/// damaged ones would overflow sums of times; the messages themselves have stamps of their own.
constexpr Stamp kLastTime =
    Stamp{std::numeric_limits<std::uint32_t>::max()} * kNanosecondsPerSecond + 999'999'999;

/// The time of ROS that is nearest to a time of the database.
Stamp in_range(std::int64_t time) { return std::clamp<Stamp>(time, 0, kLastTime); }

bool begins_with(const std::string& text, const std::string& with) {
  return text.compare(0, with.size(), with) == 0;
}

}  // namespace

/// A query whose rows are read one after the other.
class Ros2File::Statement {
 public:
  Statement(const Ros2File& file, const std::string& query) : file_(file) {
    sqlite3* database = file.database_.get();
    if (sqlite3_prepare_v2(database, query.c_str(), -1, &statement_, nullptr) != SQLITE_OK) {
      file.fail(sqlite3_errmsg(database));
    }
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// False after the last row.
  bool next() {
    const int result = sqlite3_step(statement_);
    if (result == SQLITE_ROW) return true;
    if (result != SQLITE_DONE) file_.fail(sqlite3_errstr(result));
    return false;
  }
  bool is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::int64_t number(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text == nullptr ? "" : text;
  }
  /// Valid until the next row.
  ByteRange bytes(int column) const {
    const void* first = sqlite3_column_blob(statement_, column);
    return {static_cast<const std::uint8_t*>(first),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }

 private:
  const Ros2File& file_;
  sqlite3_stmt* statement_ = nullptr;
};

bool Ros2File::is_one(const std::string& path) {
  const std::string begin = beginning_of(path, kSqlite.size());
  if (begins_with(begin, kZstandard)) {
    throw FileError("cannot read the recording " + path +
                    ": it is compressed; zstd -d decompresses it");
  }
  return begins_with(begin, kSqlite);
}

Ros2File::Ros2File(const std::string& path, const WantedTopics& topics) : path_(path) {
  sqlite3* database = nullptr;
  const int result = sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
  database_.reset(database, sqlite3_close);
  if (result != SQLITE_OK) fail(sqlite3_errstr(result));
  read_topics(topics);
  count_messages();
}

Ros2File::~Ros2File() = default;

void Ros2File::fail(const std::string& reason) const {
  throw FileError("cannot read the recording " + path_ + ": " + reason +
                  "; copy it again, or try sqlite3's .recover");
}

void Ros2File::read_topics(const WantedTopics& topics) {
  Statement rows(*this, "SELECT id, name, type, serialization_format FROM topics");
  while (rows.next()) {
    const std::string name = rows.text(1);
    if (!is_wanted(name, topics)) continue;
    if (rows.text(3) != "cdr") {
      fail("topic " + name + " is serialised as '" + rows.text(3) + "', not as cdr");
    }
    const std::string type = rows.text(2);
    connections_[rows.number(0)] = ros2_connection(name, type);
    if (const Ros2Type* known = ros2_type(type)) types_[rows.number(0)] = known;
  }
}

std::string Ros2File::of_topics() const {
  std::vector<std::string> ids;
  for (const auto& [id, connection] : connections_) ids.push_back(std::to_string(id));
  return " WHERE topic_id IN (" + joined(ids) + ")";
}

void Ros2File::count_messages() {
  Statement rows(*this,
                 "SELECT topic_id, count(*) FROM messages" + of_topics() + " GROUP BY topic_id");
  while (rows.next()) {
    const auto connection = connections_.find(rows.number(0));
    const std::int64_t count = std::max<std::int64_t>(0, rows.number(1));
    if (connection == connections_.end()) continue;
    connection->second.messages = static_cast<std::uint64_t>(count);
  }
}

std::optional<std::pair<Stamp, Stamp>> Ros2File::times() const {
  Statement row(*this, "SELECT min(timestamp), max(timestamp) FROM messages" + of_topics() +
                           " AND timestamp BETWEEN 0 AND " + std::to_string(kLastTime));
  if (!row.next() || row.is_null(0)) return std::nullopt;
  return std::pair{row.number(0), row.number(1)};
}

void Ros2File::begin_reading() {
  has_row_ = false;
  reading_ = std::make_unique<Statement>(
      *this, "SELECT timestamp, topic_id, data FROM messages" + of_topics() +
                 " AND timestamp >= " + std::to_string(from_) + " ORDER BY timestamp, id");
  has_row_ = reading_->next();
}

void Ros2File::skip_to(Stamp stamp) {
  from_ = stamp;
  reading_.reset();
}

std::optional<Stamp> Ros2File::next_time() {
  if (!reading_) begin_reading();
  return has_row_ ? std::optional<Stamp>(in_range(reading_->number(0))) : std::nullopt;
}

Ros2Message Ros2File::next() {
  Ros2Message message;
  message.recorded = in_range(reading_->number(0));
  const auto type = types_.find(reading_->number(1));
  if (type != types_.end()) {
    message.connection = &connections_.at(type->first);
    try {
      message.data = std::make_shared<std::vector<std::uint8_t>>(
          from_cdr(reading_->bytes(2), type->second->layout));
    } catch (const InputError& error) {
      message.damage = path_ + ": on " + message.connection->topic + " " + error.what();
    }
  }
  has_row_ = false;  // also if reading on fails
  has_row_ = reading_->next();
  return message;
}

}  // namespace lidar_mapping::ros_border
