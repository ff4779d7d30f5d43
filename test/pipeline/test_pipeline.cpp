// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <map>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"

#include "file_content.hpp"
#include "near.hpp"
#include "simulated_input.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

namespace fs = std::filesystem;
using session::Session;
using test::files_in;
using test::SimulatedInput;
using test::TemporaryFolder;

simulation::DriveOptions short_drive() {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  options.duration = 12.0;
  return options;
}

PipelineReport map_drive(const SimulatedInput& recorded, const fs::path& folder, int threads) {
  SimulatedInput input = recorded;
  PipelineConfig config;
  config.threads = threads;
  Pipeline pipeline(config, Session::create_in(folder),
                    [&](const std::string& frame) { return input.T_base(frame); });
  while (auto datum = input.next()) pipeline.add(std::move(*datum));
  return pipeline.finish();
}

/// Largest error of the positions relative to the first key frame, of the key frames from `seconds`
/// after the beginning on, m.
double error_of(const Session& session, const simulation::Drive& drive, double seconds = 0.0) {
  std::vector<KeyFramePose> poses = session.poses().poses;
  const Stamp begin = drive.scan_stamp(0) + from_seconds(seconds);
  poses.erase(poses.begin(), std::find_if(poses.begin(), poses.end(),
                                          [&](const auto& pose) { return pose.stamp >= begin; }));
  double largest = poses.empty() ? 1e9 : 0.0;
  const auto truth = [&](const KeyFramePose& pose) { return drive.trajectory().pose(pose.stamp); };
  for (const KeyFramePose& pose : poses) {
    const KeyFramePose& first = poses.front();
    const Pose estimate = first.T_map_base.inverse() * pose.T_map_base;
    const Pose expected = truth(first).inverse() * truth(pose);
    largest = std::max(largest, (estimate.translation - expected.translation).norm());
  }
  return largest;
}

// Such rates come from an IMU without a gyro, or from one in degrees/s that was rejected.
TEST(Pipeline, IgnoresInvalidRates) {
  const TemporaryFolder folder;
  SimulatedInput input(short_drive());
  {
    Pipeline pipeline({}, Session::create_in(folder.path()),
                      [&](const std::string& frame) { return input.T_base(frame); });
    while (auto datum = input.next()) {
      if (auto* imu = std::get_if<FramedSample<ImuSample>>(&*datum)) {
        imu->sample.has_angular_velocity = false;
        imu->sample.angular_velocity.z() = 5.0;
      }
      pipeline.add(std::move(*datum));
    }
    pipeline.finish();
  }
  EXPECT_LT(error_of(Session::open(folder.path(), Session::Access::kRead), input.drive()), 0.3);
}

// The floor of a storey shares voxels with the ceiling of the one below, and base_link lies on the
// floor: only the position of the LiDAR tells that the floor is seen from above.
TEST(Pipeline, KeepsHeightOnRampOfCarPark) {
  constexpr double kBeginOfRamp = 40.0;  // s
  simulation::DriveOptions options;
  options.drive = "car_park";
  options.lidar = "vlp16";
  options.seed = 67;
  options.duration = 64.0;
  SimulatedInput input(options);
  const TemporaryFolder folder;
  {
    Pipeline pipeline({}, Session::create_in(folder.path()),
                      [&](const std::string& frame) { return input.T_base(frame); });
    while (auto datum = input.next()) {
      if (std::holds_alternative<RecordedScan>(*datum)) pipeline.add(std::move(*datum));
    }
    pipeline.finish();
  }
  const Session session = Session::open(folder.path(), Session::Access::kRead);
  EXPECT_LT(error_of(session, input.drive(), kBeginOfRamp), 0.1);
}

TEST(Pipeline, GivesTheSameBytesForAnyNumberOfThreads) {
  const SimulatedInput input(short_drive());
  const TemporaryFolder one, four;
  const PipelineReport report = map_drive(input, one.path(), 1);
  map_drive(input, four.path(), 4);
  EXPECT_EQ(report.progress.scans, input.drive().scan_count());
  EXPECT_GT(report.progress.key_frames, 10U);
  EXPECT_GT(report.optimization.gnss_used, 0U);
  const auto files = files_in(one.path());
  const auto others = files_in(four.path());
  EXPECT_GT(files.size(), report.progress.key_frames);
  ASSERT_EQ(files.size(), others.size());
  for (const auto& [name, content] : files) EXPECT_TRUE(content == others.at(name)) << name;
  const Session session = Session::open(one.path(), Session::Access::kRead);
  EXPECT_EQ(session.scans().size(), input.drive().scan_count());
  EXPECT_LT(error_of(session, input.drive()), 0.3);
}

/// Ends like a killed process: what is in the queues is lost.
void interrupt(const SimulatedInput& recorded, const fs::path& folder, std::size_t inputs) {
  SimulatedInput input = recorded;
  Pipeline pipeline({}, Session::create_in(folder),
                    [&](const std::string& frame) { return input.T_base(frame); });
  for (std::size_t i = 0; i < inputs; ++i) pipeline.add(*input.next());
}

void resume(const SimulatedInput& recorded, const fs::path& folder, bool whole) {
  SimulatedInput input = recorded;
  PipelineConfig config;
  config.replay_whole = whole;
  Pipeline pipeline(config, Session::open(folder, Session::Access::kWrite),
                    [&](const std::string& frame) { return input.T_base(frame); });
  if (const auto stamp = pipeline.resume_time()) input.skip_to(*stamp);
  while (auto datum = input.next()) pipeline.add(std::move(*datum));
  pipeline.finish();
}

KeyFramePoses poses_in(const fs::path& folder) {
  return Session::open(folder, Session::Access::kRead).poses();
}

TEST(Pipeline, ResumedSessionEqualsUninterruptedOne) {
  const SimulatedInput input(short_drive());
  const TemporaryFolder whole, interrupted;
  map_drive(input, whole.path(), 2);
  interrupt(input, interrupted.path(), 1500);
  ASSERT_GT(Session::open(interrupted.path(), Session::Access::kRead).key_frame_count(), 0U);
  resume(input, interrupted.path(), false);
  const KeyFramePoses expected = poses_in(whole.path());
  const KeyFramePoses poses = poses_in(interrupted.path());
  ASSERT_EQ(poses.poses.size(), expected.poses.size());
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    EXPECT_EQ(poses.poses[i].stamp, expected.poses[i].stamp);
    EXPECT_TRUE(test::near(poses.poses[i].T_map_base, expected.poses[i].T_map_base, 0.01));
  }
}

TEST(Pipeline, CountsKeyFramesOfResumedSession) {
  const SimulatedInput input(short_drive());
  const TemporaryFolder folder;
  interrupt(input, folder.path(), 1500);
  Session session = Session::open(folder.path(), Session::Access::kWrite);
  const std::size_t key_frames = session.key_frame_count();
  ASSERT_GT(key_frames, 0U);
  const Pipeline pipeline({}, std::move(session),
                          [](const std::string&) { return Pose::Identity(); });
  EXPECT_EQ(pipeline.progress().key_frames, key_frames);
}

TEST(Pipeline, RejectsAnotherRecordingOnResuming) {
  const SimulatedInput input(short_drive());
  const TemporaryFolder folder;
  interrupt(input, folder.path(), 1500);
  simulation::DriveOptions other = short_drive();
  other.scan_rate = 9.0;
  EXPECT_THROW(resume(SimulatedInput(other), folder.path(), false), InputError);
}

TEST(Pipeline, ReportsNoSuccessWithoutScans) {
  const TemporaryFolder folder;
  Pipeline pipeline({}, Session::create_in(folder.path()),
                    [](const std::string&) { return std::nullopt; });
  EXPECT_FALSE(pipeline.finish().optimization.success);
}

TEST(Pipeline, DropsScanThatCannotBeDecoded) {
  const TemporaryFolder folder;
  Pipeline pipeline({}, Session::create_in(folder.path()),
                    [](const std::string&) { return Pose::Identity(); });
  pipeline.add(RecordedScan{
      1, [](const PointCloud&) -> preprocessing::RawScan { throw InputError("cut off"); }});
  EXPECT_EQ(pipeline.finish().scans_unreadable, 1U);
  const std::vector<std::string> messages = pipeline.take_messages();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_NE(messages[0].find("cut off"), std::string::npos);
}

TEST(Pipeline, ThrowsErrorOfDisk) {
  const SimulatedInput recorded(short_drive());
  SimulatedInput input = recorded;
  const TemporaryFolder folder;
  Pipeline pipeline({}, Session::create_in(folder.path()),
                    [&](const std::string& frame) { return input.T_base(frame); });
  std::ofstream(folder.path() / "key_frames") << "a file where the folder should be";
  EXPECT_THROW(
      {
        while (auto datum = input.next()) pipeline.add(std::move(*datum));
        pipeline.finish();
      },
      FileError);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
