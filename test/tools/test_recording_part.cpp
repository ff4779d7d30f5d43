// SPDX-License-Identifier: BSD-3-Clause
#include <csignal>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "recording/recording_part.hpp"

namespace lidar_mapping::tools {
namespace {

constexpr Stamp kBegin = 1'700'000'000 * kNanosecondsPerSecond;
constexpr Stamp kSecond = kNanosecondsPerSecond;
constexpr Stamp kNever = std::numeric_limits<Stamp>::max();

/// A recording of so many seconds, of which nothing is read.
class Recording : public pipeline::InputSource {
 public:
  explicit Recording(Stamp seconds) : end_(kBegin + seconds * kSecond) {}
  std::optional<pipeline::Input> next() override { return std::nullopt; }
  void skip_to(Stamp /*stamp*/) override {}
  Stamp begin() const override { return kBegin; }
  Stamp end() const override { return end_; }
  std::optional<Pose> T_base(const std::string& /*frame_id*/) const override {
    return std::nullopt;
  }

 private:
  Stamp end_;
};

using Milliseconds = std::vector<Stamp>;

/// Begin, end and limit of a part of a minute, since its begin; -1 for no limit.
Milliseconds part(double start, double duration) {
  const RecordingPart chosen = chosen_part(Recording(60), start, duration);
  const auto after = [](Stamp stamp) { return (stamp - kBegin) / 1'000'000; };
  const bool is_limited = chosen.limit != kNever;
  return {after(chosen.begin), after(chosen.end), is_limited ? after(chosen.limit) : -1};
}

TEST(RecordingPart, IsTheWholeOneWithoutAChoice) {
  EXPECT_EQ(part(0.0, 0.0), Milliseconds({0, 60'000, -1}));
}

TEST(RecordingPart, BeginsAndEndsWhereItIsWanted) {
  EXPECT_EQ(part(2.5, 0.0), Milliseconds({2'500, 60'000, -1}));
  EXPECT_EQ(part(0.0, 8.0), Milliseconds({0, 8'000, 8'000}));
  EXPECT_EQ(part(50.0, 9.5), Milliseconds({50'000, 59'500, 59'500}));
}

TEST(RecordingPart, HasNoLimitWhereTheRecordingEndsBefore) {
  EXPECT_EQ(part(0.0, 60.0), Milliseconds({0, 60'000, -1}));
  EXPECT_EQ(part(50.0, 10.5), Milliseconds({50'000, 60'000, -1}));
}

TEST(RecordingPart, TakesAnyNumberOfSeconds) {
  for (const double seconds : {1e9, 1e10, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(part(1.0, seconds), Milliseconds({1'000, 60'000, -1})) << seconds;
    EXPECT_THROW(part(seconds, 0.0), InputError) << seconds;
  }
}

TEST(RecordingPart, SaysHowLongTheRecordingIs) {
  for (const double start : {60.0, 61.0}) {
    const std::string text = test::error_text<InputError>([&] { part(start, 0.0); });
    EXPECT_NE(text.find("--start 6"), std::string::npos) << text;
    EXPECT_NE(text.find("lasts 60.0"), std::string::npos) << text;
  }
  EXPECT_THROW(chosen_part(Recording(0), 0.1, 0.0), InputError);
  EXPECT_NO_THROW(chosen_part(Recording(0), 0.0, 1.0)) << "that it is empty is said elsewhere";
}

pipeline::Input scan_at(double seconds) {
  pipeline::RecordedScan scan;
  scan.stamp = kBegin + from_seconds(seconds);
  return scan;
}

pipeline::Input imu_at(double seconds) {
  pipeline::FramedSample<ImuSample> imu;
  imu.sample.stamp = kBegin + from_seconds(seconds);
  return imu;
}

/// Hands out what it was given.
class Data : public Recording {
 public:
  explicit Data(std::vector<pipeline::Input> data) : Recording(60), data_(std::move(data)) {}
  std::optional<pipeline::Input> next() override {
    if (next_ == data_.size()) return std::nullopt;
    return std::move(data_[next_++]);
  }
  std::size_t read() const { return next_; }

 private:
  std::vector<pipeline::Input> data_;
  std::size_t next_ = 0;
};

/// Number of data that are used up to 10 s.
int used_of(Data& data) {
  const volatile std::sig_atomic_t goes_on = 0;
  int used = 0;
  read_until(kBegin + 10 * kSecond, goes_on, data, [&](pipeline::Input&& /*datum*/) { ++used; });
  return used;
}

TEST(ReadUntil, EndsAfterFiveScansInARowBehindTheLimit) {
  std::vector<pipeline::Input> data;
  for (int i = 0; i < 4; ++i) data.push_back(scan_at(10.0 + 0.1 * i));
  data.push_back(scan_at(9.95));  // the stamps before were wrong
  for (int i = 0; i < 20; ++i) data.push_back(scan_at(10.0 + 0.1 * i));
  Data recording(std::move(data));
  EXPECT_EQ(used_of(recording), 1);
  EXPECT_EQ(recording.read(), 10U);
}

// What comes late may belong to a scan before the limit.
TEST(ReadUntil, GoesByScansAlone) {
  std::vector<pipeline::Input> data;
  for (int i = 0; i < 20; ++i) data.push_back(imu_at(50.0));
  data.push_back(scan_at(11.0));
  data.push_back(imu_at(50.0));
  data.push_back(scan_at(9.9));
  Data recording(std::move(data));
  EXPECT_EQ(used_of(recording), 22);
}

TEST(ReadUntil, EndsWhenItIsAskedTo) {
  std::vector<pipeline::Input> data;
  for (int i = 0; i < 5; ++i) data.push_back(scan_at(1.0));
  Data recording(std::move(data));
  volatile std::sig_atomic_t ends = 0;
  read_until(kNever, ends, recording, [&](pipeline::Input&& /*datum*/) { ends = 1; });
  EXPECT_EQ(recording.read(), 1U);
}

}  // namespace
}  // namespace lidar_mapping::tools
