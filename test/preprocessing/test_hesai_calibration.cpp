// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/preprocessing/hesai_calibration.hpp"

#include "error_text.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::preprocessing {
namespace {

class HesaiCalibrations : public testing::Test {
 protected:
  HesaiCalibration read(const std::string& text) const {
    std::ofstream(path()) << text;
    return read_hesai_calibration(path());
  }
  void expect_refusal(const std::string& text, const std::string& words) const {
    const std::string refusal = test::error_text<ConfigError>([&] { read(text); });
    EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
    EXPECT_NE(refusal.find(path()), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("; name a file of lines"), std::string::npos) << refusal;
  }
  std::string path() const { return folder_.path() / "lasers.csv"; }

  const test::TemporaryFolder folder_;
};

/// Lines of the channels from `first` to `last`.
std::string channels(int first, int last, const std::string& end_of_line = "\n") {
  std::string text;
  for (int i = first; i <= last; ++i) {
    text += std::to_string(i) + "," + std::to_string(20.5 - i) + ",-1.042" + end_of_line;
  }
  return text;
}

void expect_channels(const HesaiCalibration& calibration, std::size_t count) {
  ASSERT_EQ(calibration.lasers.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(calibration.lasers[i].elevation, (19.5 - static_cast<double>(i)) * kRadPerDeg,
                1e-12);
    EXPECT_NEAR(calibration.lasers[i].azimuth, -1.042 * kRadPerDeg, 1e-12);
  }
}

TEST_F(HesaiCalibrations, AreReadInTheFormsThatThereAre) {
  expect_channels(read("Channel,Elevation,Azimuth\n" + channels(1, 32)), 32);
  expect_channels(read("Laser id,Elevation,Azimuth\n" + channels(1, 64)), 64);
  expect_channels(read("\xEF\xBB\xBF"
                       "Channel,Elevation,Azimuth\r\n" +
                       channels(1, 40, "\r\n")),
                  40);
  expect_channels(read("Channel, Elevation, Azimuth\n" + channels(9, 16) + channels(1, 8) + "\n"),
                  16);
  std::string without_end = channels(1, 16);
  without_end.pop_back();
  expect_channels(read(without_end), 16);
}

TEST_F(HesaiCalibrations, AreRefusedWithFileAndLine) {
  const std::string names = "Channel,Elevation,Azimuth\n";
  expect_refusal("", ": 0 channels instead of 16, 32, 40 or 64");
  expect_refusal(names + channels(1, 20), ": 20 channels instead of 16, 32, 40 or 64");
  expect_refusal(names + channels(2, 17), ": 16 channels, but the last one is 17");
  expect_refusal(names + channels(1, 5) + "6;7.5;1\n", ", line 7: 1 values instead of 3");
  expect_refusal(names + "1,2,3,4\n", ", line 2: 4 values instead of 3");
  expect_refusal(names + "one,2,3\n", ", line 2: 'one' is no whole number from 1 to 64");
  expect_refusal("65,2,3\n", ", line 1: '65' is no whole number from 1 to 64");
  expect_refusal(names + channels(1, 2) + "3,nan,0\n", ", line 4: 'nan' is no finite number");
  expect_refusal(names + "1,,0\n", ", line 2: '' is no finite number");
  expect_refusal(names + "1,91,0\n", ", line 2: an angle of 91 degrees is beyond 90");
  expect_refusal(names + "1,0,-181\n", ", line 2: an angle of -181 degrees is beyond 180");
  expect_refusal(names + channels(1, 3) + channels(3, 16), ", line 5: channel 3 is there twice");
  expect_refusal(channels(1, 3) + names, ", line 4: 'Channel' is no whole number");
}

TEST_F(HesaiCalibrations, OfAFileThatIsNotThereAreNamed) {
  EXPECT_THROW(read_hesai_calibration(folder_.path() / "none.csv"), FileError);
  EXPECT_THROW(read_hesai_calibration(folder_.path()), FileError);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
