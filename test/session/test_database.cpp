// SPDX-License-Identifier: BSD-3-Clause
// What cells of a session's tables may hold; what damaged ones say.

#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "database.hpp"
#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::session {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class DatabaseTest : public testing::Test {
 protected:
  DatabaseTest() : path_(folder_.path() / "session.db"), database_(path_, Database::Mode::kCreate) {
    database_.execute("CREATE TABLE things (a, b, c, d, e, f, g)");
  }

  /// A statement on the only row, which has these cells.
  Statement row(Cells cells) {
    database_.execute("DELETE FROM things");
    cells.resize(7, nullptr);
    database_.run("INSERT INTO things VALUES (?, ?, ?, ?, ?, ?, ?)", cells);
    Statement statement = database_.query("SELECT * FROM things");
    EXPECT_TRUE(statement.step());
    return statement;
  }
  std::int64_t count() {
    Statement statement = database_.query("SELECT COUNT(*) FROM things");
    statement.step();
    return statement.read_integer();
  }
  void insert() { database_.run("INSERT INTO things (a) VALUES (?)", {std::int64_t{1}}); }

  test::TemporaryFolder folder_;
  std::filesystem::path path_;
  Database database_;
};

/// The message of the FileError of an action; empty if there was none.
template <typename Action>
std::string error_of(const Action& action) {
  return test::error_text<FileError>(action);
}

TEST_F(DatabaseTest, GivesBackWhatWasWritten) {
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
  const std::string text("with a zero\0in it, 'quotes' and \xC3\xA4", 35);
  const Blob blob = {1.0 / 3.0, -0.0, 5e-324, 1e100};
  Statement statement = row({kLargest, -kLargest, 0.1, text, blob, nullptr, std::string()});
  EXPECT_EQ(statement.read_integer(), kLargest);
  EXPECT_EQ(statement.read_integer(), -kLargest);
  EXPECT_EQ(statement.read_real(), 0.1);
  EXPECT_EQ(statement.read_text(), text);
  EXPECT_EQ(statement.read_blob(), blob);
  EXPECT_TRUE(statement.next_is_null());
  EXPECT_EQ(statement.next_column(), 5);
  statement.skip(1);
  EXPECT_FALSE(statement.next_is_null()) << "an empty text is none";
  EXPECT_EQ(statement.read_text(), "");
  EXPECT_FALSE(statement.step()) << "there is one row";
}

TEST_F(DatabaseTest, GivesBackPosesAndMatrices) {
  const Pose pose{exp_so3({0.3, -2.0, 1.0}), {12345.678, -0.001, 9e8}};
  Cells cells;
  append(cells, pose);
  ASSERT_EQ(cells.size(), 7U);
  const Pose read = row(cells).read_pose();
  EXPECT_EQ(read.translation, pose.translation);
  EXPECT_EQ(read.rotation.coeffs(), pose.rotation.coeffs());
  Eigen::Matrix<double, 2, 3> matrix;
  matrix << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  const Blob blob = row({to_blob(matrix)}).read_blob(6);
  EXPECT_EQ(blob, (Blob{1.0, 2.0, 3.0, 4.0, 5.0, 6.0})) << "row by row";
  EXPECT_EQ((to_matrix<Eigen::Matrix<double, 2, 3>>(blob)), matrix);
}

TEST_F(DatabaseTest, ReadsEmptyCellsAsNothing) {
  EXPECT_EQ(row({}).read_integer(), 0);
  EXPECT_EQ(row({}).read_real(), 0.0);
  EXPECT_EQ(row({}).read_text(), "");
  EXPECT_TRUE(row({}).read_blob().empty());
  EXPECT_EQ(row({}).read_blob(3), (Blob{0.0, 0.0, 0.0}));
  EXPECT_EQ(row({Blob()}).read_blob(3), (Blob{0.0, 0.0, 0.0}));
  EXPECT_NE(error_of([&] { row({}).read_coordinate(); }), "") << "a place has to be known";
}

TEST_F(DatabaseTest, RefusesCellsOfAnotherKind) {
  const std::string text = "twelve";
  EXPECT_NE(error_of([&] { row({text}).read_integer(); }), "");
  EXPECT_NE(error_of([&] { row({1.5}).read_integer(); }), "");
  EXPECT_NE(error_of([&] { row({Blob{1.0}}).read_integer(); }), "");
  EXPECT_NE(error_of([&] { row({text}).read_real(); }), "");
  EXPECT_NE(error_of([&] { row({Blob{1.0}}).read_real(); }), "");
  EXPECT_NE(error_of([&] { row({text}).read_blob(); }), "");
  EXPECT_NE(error_of([&] { row({2.0}).read_blob(); }), "");
  EXPECT_EQ(row({std::int64_t{3}}).read_real(), 3.0) << "a whole number is a number";
}

TEST_F(DatabaseTest, RefusesNumbersThatCannotBe) {
  EXPECT_NE(error_of([&] { row({std::int64_t{-1}}).read_integer(0, 10); }), "");
  EXPECT_NE(error_of([&] { row({std::int64_t{11}}).read_integer(0, 10); }), "");
  EXPECT_EQ(row({std::int64_t{10}}).read_integer(0, 10), 10);
  EXPECT_EQ(row({std::int64_t{0}}).read_integer(0, 10), 0);
  for (const double damaged : {kInfinity, -kInfinity, 1.1e9, -1e300}) {
    EXPECT_NE(error_of([&] { row({damaged}).read_coordinate(); }), "") << damaged;
  }
  EXPECT_EQ(row({-1e9}).read_coordinate(), -1e9);
  for (const double damaged : {kInfinity, std::nan(""), -1e101}) {
    EXPECT_NE(error_of([&] { row({Blob{1.0, damaged}}).read_blob(); }), "") << damaged;
  }
}

TEST_F(DatabaseTest, RefusesMatricesOfAnotherSize) {
  const Blob six(6, 1.0);
  EXPECT_NE(error_of([&] { row({six}).read_blob(5); }), "");
  EXPECT_NE(error_of([&] { row({six}).read_blob(7); }), "");
  EXPECT_EQ(row({six}).read_blob(6), six);
  database_.execute("DELETE FROM things");
  database_.execute("INSERT INTO things (a) VALUES (x'0102030405060708090A')");
  Statement statement = database_.query("SELECT a FROM things");
  ASSERT_TRUE(statement.step());
  EXPECT_NE(error_of([&] { statement.read_blob(); }), "") << "ten bytes are no whole numbers";
}

TEST_F(DatabaseTest, RefusesRotationsThatAreNone) {
  EXPECT_NE(error_of([&] { row({0.0, 0.0, 0.0, 0.0}).read_quaternion(); }), "");
  EXPECT_NE(error_of([&] { row({1.0, 1.0, 1.0, 1.0}).read_quaternion(); }), "");
  EXPECT_NE(error_of([&] { row({0.0, 0.0, 0.0}).read_quaternion(); }), "") << "w is missing";
  EXPECT_EQ(row({0.0, 0.0, 0.0, 1.0}).read_quaternion().w(), 1.0) << "x y z w";
}

TEST_F(DatabaseTest, NamesFileColumnAndContentOfADamagedCell) {
  const std::string error = error_of([&] {
    row({std::int64_t{1}, std::string(500, 'x')}).skip(0);
  });
  EXPECT_EQ(error, "") << "what is not read is not judged";
  const std::string text = error_of([&] {
    Statement statement = row({std::int64_t{1}, std::string(500, 'x')});
    statement.skip(1);
    statement.read_real();
  });
  EXPECT_NE(text.find(path_.string()), std::string::npos) << text;
  EXPECT_NE(text.find("'" + std::string(40, 'x') + "' as b"), std::string::npos) << text;
  EXPECT_NE(text.find("damaged"), std::string::npos) << text;
}

TEST_F(DatabaseTest, DiscardsATransactionThatWasNotCommitted) {
  {
    const Transaction transaction(database_);
    insert();
    EXPECT_EQ(count(), 1);
  }
  EXPECT_EQ(count(), 0);
  {
    Transaction transaction(database_);
    insert();
    transaction.commit();
  }
  EXPECT_EQ(count(), 1);
  try {
    const Transaction transaction(database_);
    insert();
    database_.execute("INSERT INTO nowhere VALUES (1)");
  } catch (const FileError&) {
    EXPECT_EQ(count(), 1) << "an error undoes what came before it";
  }
}

// The report is made while the drive goes on, and none waits for the other.
TEST_F(DatabaseTest, IsWrittenWhileItIsRead) {
  insert();
  insert();
  const Database reader(path_, Database::Mode::kRead);
  Statement statement = reader.query("SELECT a FROM things");
  ASSERT_TRUE(statement.step());
  {
    Transaction transaction(database_);
    insert();
    transaction.commit();
  }
  EXPECT_TRUE(statement.step());
  EXPECT_FALSE(statement.step()) << "what was there when it began";
  EXPECT_EQ(count(), 3);
}

TEST_F(DatabaseTest, IsNotChangedByAReader) {
  Database reader(path_, Database::Mode::kRead);
  EXPECT_NE(error_of([&] { reader.execute("DELETE FROM things"); }).find("readonly"),
            std::string::npos);
}

// As on a disk that is kept for reading: the files that WAL mode has beside it cannot be made.
TEST_F(DatabaseTest, IsReadWhereNothingCanBeWritten) {
  namespace fs = std::filesystem;
  const fs::path folder = folder_.path() / "100 %41 kept? #1";
  fs::create_directory(folder);
  {
    Database writer(folder / "session.db", Database::Mode::kCreate);
    writer.execute("CREATE TABLE things (a)");
    writer.execute("INSERT INTO things VALUES (7)");
  }
  ASSERT_FALSE(fs::exists(folder / "session.db-wal"));
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  std::int64_t value = 0;
  const std::string error = error_of([&] {
    const Database reader(folder / "session.db", Database::Mode::kRead);
    Statement row = reader.query("SELECT a FROM things");
    if (row.step()) value = row.read_integer();
  });
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(error, "");
  EXPECT_EQ(value, 7);
}

TEST_F(DatabaseTest, NamesAFileThatCannotBeOpened) {
  const auto missing = folder_.path() / "missing.db";
  for (const auto mode : {Database::Mode::kRead, Database::Mode::kWrite}) {
    const std::string error = error_of([&] { Database(missing, mode); });
    EXPECT_NE(error.find(missing.string()), std::string::npos) << error;
  }
  EXPECT_FALSE(std::filesystem::exists(missing)) << "only kCreate makes one";
}

TEST_F(DatabaseTest, NamesAFileThatIsNoDatabase) {
  const auto other = folder_.path() / "other.db";
  std::ofstream(other) << std::string(4096, 'x');
  const std::string error = error_of([&] {
    const Database reader(other, Database::Mode::kRead);
    reader.query("SELECT * FROM things").step();
  });
  EXPECT_NE(error.find("other.db"), std::string::npos) << error;
}

}  // namespace
}  // namespace lidar_mapping::session
