// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <utility>
#include <variant>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"
#include "lidar_mapping/pipeline/recorded_odometry.hpp"
#include "lidar_mapping/pipeline/session_map.hpp"

#include "error_text.hpp"
#include "simulated_input.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::pipeline {
namespace {

using session::Session;
using test::SimulatedInput;
using test::TemporaryFolder;

const SimulatedInput& recorded() {
  static const SimulatedInput input = [] {
    simulation::DriveOptions options;
    options.lidar = "vlp16";
    options.duration = 8.0;
    return SimulatedInput(options);
  }();
  return input;
}

PipelineConfig with_threads(int threads) {
  PipelineConfig config;
  config.threads = threads;
  return config;
}

std::vector<OdometryScan> odometry_of(int threads) {
  SimulatedInput input = recorded();
  std::vector<OdometryScan> scans;
  RecordedOdometry odometry(
      with_threads(threads), [&](const std::string& frame) { return input.T_base(frame); },
      [&](OdometryScan&& scan) { scans.push_back(std::move(scan)); });
  while (auto datum = input.next()) odometry.add(std::move(*datum));
  odometry.finish();
  return scans;
}

void map_into(const std::filesystem::path& folder) {
  SimulatedInput input = recorded();
  Pipeline pipeline(with_threads(2), Session::create_in(folder),
                    [&](const std::string& frame) { return input.T_base(frame); });
  while (auto datum = input.next()) pipeline.add(std::move(*datum));
  pipeline.finish();
}

TEST(RecordedOdometry, IsThatOfAMappedDriveForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  map_into(folder.path());
  const auto mapped = Session::open(folder.path(), Session::Access::kRead).odometry();
  ASSERT_GT(mapped.size(), 70U);
  for (const int threads : {1, 3}) {
    const std::vector<OdometryScan> scans = odometry_of(threads);
    ASSERT_EQ(scans.size(), mapped.size());
    for (std::size_t i = 0; i < scans.size(); ++i) {
      EXPECT_EQ(scans[i].scan.stamp, mapped[i].stamp);
      EXPECT_EQ(scans[i].result.T_odom_base.translation, mapped[i].T_odom_base.translation);
    }
  }
}

TEST(RecordedOdometry, GivesScansInBaseLinkWithoutDistortion) {
  const SimulatedInput input = recorded();
  const std::vector<OdometryScan> scans = odometry_of(1);
  for (const OdometryScan& scan : scans) EXPECT_FALSE(scan.scan.cloud.has_times());
  EXPECT_EQ(scans.back().p_base_lidar, input.drive().mounting().T_base_lidar.translation);
  // The ground under the vehicle is at the height of base_link, not of the LiDAR.
  double sum = 0.0;
  std::size_t count = 0;
  for (const Point& p : scans.back().scan.cloud.points) {
    if (std::abs(p.x) > 8.0F || std::abs(p.y) > 2.0F || p.z > 0.6F) continue;
    sum += p.z;
    ++count;
  }
  ASSERT_GT(count, 50U);
  EXPECT_LT(std::abs(sum / static_cast<double>(count)), 0.35);
}

/// A drive of which there are only scans, and the times of their points are wrong.
std::vector<OdometryScan> odometry_with_fault(const std::string& fault) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  options.duration = 10.0;
  options.scan_faults = {simulation::parse_scan_fault(fault)};
  SimulatedInput input(options);
  PipelineConfig config = with_threads(2);
  config.front_end.key_frame_cloud_resolution = 0.0;  // key frames with all points
  std::vector<OdometryScan> scans;
  RecordedOdometry odometry(
      config, [&](const std::string& frame) { return input.T_base(frame); },
      [&](OdometryScan&& scan) { scans.push_back(std::move(scan)); });
  while (auto datum = input.next()) {
    if (std::holds_alternative<RecordedScan>(*datum)) odometry.add(std::move(*datum));
  }
  odometry.finish();
  return scans;
}

/// Points of a cloud that another one has too, in the same order, to a millimetre.
std::size_t points_in(const PointCloud& all, const PointCloud& some) {
  std::size_t found = 0;
  for (const Point& point : all.points) {
    if (found == some.size()) break;
    if ((point.position() - some.points[found].position()).norm() < 1e-3F) ++found;
  }
  return found;
}

/// Scans that are localised were bent, while the key frames of the same drive were not.
TEST(RecordedOdometry, CorrectsTheTimesOfPointsAsTheFrontEndDoes) {
  const std::pair<const char*, front_end::SweepTimes> cases[] = {
      {"times=negated", front_end::SweepTimes::kNegated},
      {"times=none", front_end::SweepTimes::kByAzimuth}};
  for (const auto& [fault, times] : cases) {
    std::size_t compared = 0;
    for (const OdometryScan& scan : odometry_with_fault(fault)) {
      if (scan.result.status.sweep_times.source != times || !scan.result.key_frame) continue;
      const PointCloud& expected = *scan.result.key_frame->cloud;
      ASSERT_EQ(points_in(scan.scan.cloud, expected), expected.size()) << fault;
      ++compared;
    }
    EXPECT_GT(compared, 3U) << fault;
  }
}

TEST(RecordedOdometry, ThrowsWhatTheReceiverThrew) {
  SimulatedInput input = recorded();
  RecordedOdometry odometry(
      with_threads(2), [&](const std::string& frame) { return input.T_base(frame); },
      [](OdometryScan&&) { throw InputError("enough"); });
  const auto read = [&] {
    while (auto datum = input.next()) odometry.add(std::move(*datum));
    odometry.finish();
  };
  EXPECT_THROW(read(), InputError);
}

TEST(SessionMap, HasThePlacesOfTheSessionAndItsDatum) {
  const TemporaryFolder folder;
  map_into(folder.path());
  SessionMap map(folder.path(), {}, 1);
  const Session session = Session::open(folder.path(), Session::Access::kRead);
  EXPECT_EQ(map.index().places().size(), session.key_frame_count());
  EXPECT_EQ(map.size_text().find(std::to_string(session.key_frame_count()) + " places, "), 0U)
      << map.size_text();
  ASSERT_TRUE(map.datum().has_value());
  EXPECT_EQ(map.datum()->latitude_deg, session.datum()->latitude_deg);
  const std::size_t coarse = map.cloud(2.0).size(), fine = map.cloud(0.5).size();
  EXPECT_GT(coarse, 300U);
  EXPECT_GT(fine, 3 * coarse);
}

TEST(SessionMap, SaysHowManyPlacesHaveNoCloud) {
  const TemporaryFolder folder;
  map_into(folder.path());
  std::size_t places = 0;
  {
    const Session session = Session::open(folder.path(), Session::Access::kRead);
    places = session.key_frame_count();
    std::filesystem::remove(session.clouds().file(1));
    std::ofstream(session.clouds().file(2)) << "damaged";
  }
  const SessionMap map(folder.path(), {}, 1);
  EXPECT_EQ(map.size_text().find(std::to_string(places) + " places, 2 of them without cloud, "), 0U)
      << map.size_text();
}

/// An imported map keeps its coordinates up to 100 km.
TEST(SessionMap, ShowsAMapThatIsFarFromItsOrigin) {
  const TemporaryFolder folder;
  const Eigen::Vector3d p_map(70'000.0, -60'000.0, 300.0);
  {
    Session session = Session::create_in(folder.path());
    KeyFrame key_frame;
    PointCloud cloud;
    for (int i = 0; i < 2000; ++i) {
      cloud.points.push_back({0.3F * static_cast<float>(i % 50), 0.3F * static_cast<float>(i / 50),
                              0.1F * static_cast<float>(i % 7), 0.5F});
    }
    key_frame.cloud = std::make_shared<const PointCloud>(cloud);
    key_frame.T_odom_base.translation = p_map;
    session.add_key_frame(key_frame);
    KeyFramePoses poses;
    poses.revision = 1;
    poses.poses = {{0, 0, key_frame.T_odom_base}};
    session::RevisionRecord record;
    record.revision = 1;
    record.key_frames = 1;
    session.set_poses(poses, record);
  }
  const PointCloud shown = SessionMap(folder.path(), {}, 1).cloud(1.0);
  ASSERT_GT(shown.size(), 100U);
  for (const Point& point : shown.points) {
    EXPECT_LT((point.position().cast<double>() - p_map).norm(), 25.0);
  }
}

TEST(SessionMap, RefusesASessionThatWasNeverOptimised) {
  const TemporaryFolder folder;
  Session::create_in(folder.path() / "empty");
  const std::string text =
      test::error_text<InputError>([&] { SessionMap(folder.path() / "empty", {}, 1); });
  EXPECT_NE(text.find("optimize_session"), std::string::npos) << text;
  EXPECT_THROW(SessionMap(folder.path() / "none", {}, 1), FileError);
}

}  // namespace
}  // namespace lidar_mapping::pipeline
