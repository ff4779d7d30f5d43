// SPDX-License-Identifier: BSD-3-Clause
#include "session_damage.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <sqlite3.h>

namespace lidar_mapping::test {

namespace {

/// As SQL writes a blob of so many bytes that are all the same: of ff, numbers that are none.
std::string blob(const char* byte, int bytes) {
  std::string text = "x'";
  for (int i = 0; i < bytes; ++i) text += byte;
  return text + "'";
}

/// As SQL writes them; 9e999 is infinity.
const std::vector<std::string>& odd_values() {
  static const std::vector<std::string> kValues = {"9e999",
                                                   "-9e999",
                                                   "1e308",
                                                   "-1e12",
                                                   "0",
                                                   "-1",
                                                   "1",
                                                   "9223372036854775807",
                                                   "-9223372036854775807",
                                                   "4294967296",
                                                   "NULL",
                                                   "''",
                                                   "'nan'",
                                                   "'wrong: [1'",
                                                   "CAST(x'c328a0' AS TEXT)",
                                                   blob("ff", 1),
                                                   blob("ff", 24),
                                                   blob("ff", 72),
                                                   blob("00", 288),
                                                   blob("66", 288)};
  return kValues;
}

using Rows = std::vector<std::string>;

int keep_second(void* rows, int columns, char** values, char**) {
  if (columns > 1 && values[1] != nullptr) static_cast<Rows*>(rows)->push_back(values[1]);
  return 0;
}

class Database {
 public:
  explicit Database(const std::string& path) {
    sqlite3* database = nullptr;
    const int code = sqlite3_open(path.c_str(), &database);
    database_.reset(database);
    if (code != SQLITE_OK) throw std::runtime_error("cannot open " + path);
  }

  /// The second column of what is found. What the tables themselves refuse stays as it is.
  Rows run(const std::string& sql) {
    Rows rows;
    sqlite3_exec(database_.get(), sql.c_str(), keep_second, &rows, nullptr);
    return rows;
  }

 private:
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> database_{nullptr, sqlite3_close};
};

}  // namespace

void spoil_session(const std::filesystem::path& path, std::mt19937& engine) {
  Database database(path.string());
  const auto one_of = [&engine](const auto& values) { return values[engine() % values.size()]; };
  const Rows tables = database.run("SELECT 0, name FROM sqlite_master WHERE type = 'table'");
  const std::size_t cells = 1 + engine() % 3;
  for (std::size_t i = 0; i < cells; ++i) {
    const std::string table = one_of(tables);
    const std::string column = one_of(database.run("PRAGMA table_info(" + table + ")"));
    const std::string first = one_of(database.run("PRAGMA table_info(" + table + ")"));
    database.run("UPDATE " + table + " SET " + column + " = " + one_of(odd_values()) + " WHERE " +
                 first + " IN (SELECT " + first + " FROM " + table + " ORDER BY 1 LIMIT 1 OFFSET " +
                 std::to_string(engine() % 6) + ")");
  }
}

}  // namespace lidar_mapping::test
