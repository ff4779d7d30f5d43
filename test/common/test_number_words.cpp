// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_words.hpp"

#include "error_text.hpp"
#include "near.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

TEST(FiniteNumber, IsReadAsPeopleAndProgramsWriteIt) {
  EXPECT_EQ(finite_number("-12.5"), -12.5);
  EXPECT_EQ(finite_number("+3"), 3.0);
  EXPECT_EQ(finite_number("1e-3"), 0.001);
  EXPECT_EQ(finite_number(".5"), 0.5);
  EXPECT_EQ(finite_number("1.7976931348623157e308"), std::numeric_limits<double>::max());
}

TEST(FiniteNumber, RefusesEverythingElse) {
  for (const std::string word :
       {"", "x", "1x", "1,5", "1 2", "nan", "inf", "-inf", "1e999", "--1", "1e"}) {
    EXPECT_THROW(finite_number(word), InputError) << "'" << word << "'";
  }
}

TEST(FiniteNumber, QuotesTheWordAndCutsALongOne) {
  const std::string text =
      test::error_text<InputError>([] { finite_number(std::string(41, 'a') + "end"); });
  EXPECT_NE(text.find("'" + std::string(40, 'a') + "...'"), std::string::npos) << text;
  EXPECT_EQ(text.find("end"), std::string::npos) << text;
}

TEST(Coordinate, IsAPlaceOnEarth) {
  EXPECT_EQ(coordinate("1e9"), 1e9);
  EXPECT_EQ(coordinate("-1e9"), -1e9);
  EXPECT_THROW(coordinate("1.001e9"), InputError);
  EXPECT_THROW(coordinate("-1.001e9"), InputError);
}

TEST(WholeNumber, LiesBetweenItsLimits) {
  EXPECT_EQ(whole_number("0", 0, 7), 0);
  EXPECT_EQ(whole_number("7", 0, 7), 7);
  EXPECT_EQ(whole_number("-3", -3, 7), -3);
  for (const std::string word :
       {"8", "-1", "", "3.0", "3 ", " 3", "3x", "1e0", "0x3", "99999999999999999999"}) {
    EXPECT_THROW(whole_number(word, 0, 7), InputError) << "'" << word << "'";
  }
}

// A double has 53 bits: these nanoseconds would come back as others.
TEST(Stamps, OfNanosecondsKeepEveryDigit) {
  EXPECT_EQ(stamp_of_nanoseconds("1317384506123456789"), 1317384506123456789);
  EXPECT_EQ(stamp_of_nanoseconds("-5"), -5);
}

TEST(Stamps, OfSecondsKeepEveryDigit) {
  EXPECT_EQ(stamp_of_seconds("1317384506.123456789"), 1317384506123456789);
  EXPECT_EQ(stamp_of_seconds("1317384506"), 1317384506000000000);
  EXPECT_EQ(stamp_of_seconds(".5"), 500'000'000);
  EXPECT_EQ(stamp_of_seconds("-2.5"), -2'500'000'000);
  EXPECT_EQ(stamp_of_seconds("2.5e1"), 25'000'000'000);
  for (const char* word : {"", ".", "1.5.2", "5e9", "noon"}) {
    EXPECT_THROW(stamp_of_seconds(word), InputError) << word;
  }
}

TEST(Stamps, EndInTheYear2112) {
  EXPECT_EQ(stamp_of_seconds(2.5), 2'500'000'000);
  EXPECT_EQ(stamp_of_seconds(-2.5), -2'500'000'000);
  EXPECT_NO_THROW(stamp_of_seconds(4.49e9));
  EXPECT_NO_THROW(stamp_of_nanoseconds("4500000000000000000"));
  EXPECT_THROW(stamp_of_seconds(4.5e9), InputError);
  EXPECT_THROW(stamp_of_seconds(-4.5e9), InputError);
  EXPECT_THROW(stamp_of_nanoseconds("4500000000000000001"), InputError);
  EXPECT_THROW(stamp_of_seconds(std::numeric_limits<double>::quiet_NaN()), InputError);
}

TEST(RigidPose, AcceptsTheDigitsThatPeopleKeep) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<2, 2>() << 0.866, -0.5, 0.5, 0.866;  // 30 degrees in three digits
  matrix.topRightCorner<3, 1>() << 1.0, 2.0, 3.0;
  const Pose pose = rigid_pose(matrix);
  EXPECT_TRUE(test::near(pose.translation, Eigen::Vector3d(1.0, 2.0, 3.0), 1e-12));
  EXPECT_NEAR(yaw_of(pose.rotation), 0.5235987756, 1e-3);
  EXPECT_NEAR(pose.rotation.norm(), 1.0, 1e-12);
}

TEST(RigidPose, RefusesAMatrixWithoutARotation) {
  const auto with_axes = [](const Eigen::Matrix3d& axes) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = axes;
    return matrix;
  };
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  EXPECT_NO_THROW(rigid_pose(with_axes(1.02 * unit)));
  EXPECT_THROW(rigid_pose(with_axes(1.03 * unit)), InputError) << "its square is 6 % too large";
  EXPECT_THROW(rigid_pose(with_axes(Eigen::Matrix3d::Zero())), InputError);
  EXPECT_THROW(rigid_pose(with_axes(Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal())), InputError)
      << "a mirror";
  Eigen::Matrix3d sheared = unit;
  sheared(0, 1) = 0.06;
  EXPECT_THROW(rigid_pose(with_axes(sheared)), InputError);
  Eigen::Matrix3d undefined = unit;
  undefined(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(rigid_pose(with_axes(undefined)), InputError);
}

class ReadNumbers : public testing::Test {
 protected:
  std::vector<double> read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_numbers(path_);
  }
  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "numbers.txt";
};

TEST_F(ReadNumbers, TakesAnyWhiteSpaceBetweenThem) {
  EXPECT_EQ(read("1 2.5\t-3\n\n 4e1  \n"), (std::vector<double>{1.0, 2.5, -3.0, 40.0}));
  EXPECT_TRUE(read("").empty());
}

TEST_F(ReadNumbers, NamesFileAndLineOfAWordThatIsNone) {
  EXPECT_EQ(test::error_text<FileError>([&] { read("1 2\n3 four\n"); }),
            path_.string() + ":2: 'four' is no finite number");
  EXPECT_THROW(read_numbers(folder_.path() / "missing.txt"), FileError);
}

}  // namespace
}  // namespace lidar_mapping
