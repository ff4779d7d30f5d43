// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lidar_mapping/common/pose.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace lidar_mapping::session {

/// The content of a cell of a table; matrices are blobs of doubles, row by row.
using Blob = std::vector<double>;
using Cell = std::variant<std::nullptr_t, std::int64_t, double, std::string, Blob>;
using Cells = std::vector<Cell>;

/// A prepared statement. After step() has returned true, the read_ functions read the cells of the
/// row from left to right. All functions throw FileError, also if a cell does not hold what its
/// column requires.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& sql, const Cells& values);

  bool step();
  bool next_is_null() const;
  std::int64_t read_integer(std::int64_t min_value = std::numeric_limits<std::int64_t>::min(),
                            std::int64_t max_value = std::numeric_limits<std::int64_t>::max());
  double read_real();
  /// A number between -1e9 and 1e9.
  double read_coordinate();
  std::string read_text();
  Blob read_blob();
  /// A blob of `size` numbers; zeros for an empty cell.
  Blob read_blob(std::size_t size);
  Eigen::Vector3d read_vector();
  Eigen::Quaterniond read_quaternion();
  Pose read_pose();
  void skip(int cells) { column_ += cells; }
  /// Throws FileError with the file and the column unless `is_sound`.
  void require(bool is_sound, int column, const std::string& expected) const;
  int next_column() const { return column_; }

 private:
  int type_of(int column) const;
  void bind(int position, const Cell& value);

  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int column_ = 0;
};

/// A SQLite file. Writers use WAL mode, so that readers need not wait for them; where nothing can
/// be written it is read all the same. All functions throw FileError.
class Database {
 public:
  enum class Mode { kCreate, kWrite, kRead };
  Database(const std::filesystem::path& path, Mode mode);

  void execute(const std::string& sql);
  void run(const std::string& sql, const Cells& values);
  Statement query(const std::string& sql, const Cells& values = {}) const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Close> database_;
};

/// A transaction: it is rolled back at the end of its scope unless it was committed.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool committed_ = false;
};

// These throw InputError for numbers that the read_ functions refuse: a single one would make the
// whole table unreadable.
void append(Cells& cells, const Eigen::Vector3d& vector);
/// Appends qx qy qz qw.
void append(Cells& cells, const Eigen::Quaterniond& rotation);
/// Appends x y z qx qy qz qw.
void append(Cells& cells, const Pose& pose);
void append(Cells& cells, const Blob& blob);

template <typename Matrix>
Blob to_blob(const Matrix& matrix) {
  Blob blob;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      blob.push_back(matrix(row, column));
    }
  }
  return blob;
}

/// A matrix of fixed size from a blob of the same size.
template <typename Matrix>
Matrix to_matrix(const Blob& blob) {
  Matrix matrix;
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix(i / matrix.cols(), i % matrix.cols()) = blob[i];
  }
  return matrix;
}

}  // namespace lidar_mapping::session
