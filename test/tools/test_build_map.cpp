// SPDX-License-Identifier: BSD-3-Clause
// build_map through the command itself.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lidar_mapping/common/dates.hpp"
#include "lidar_mapping/common/trajectory.hpp"

#include "file_content.hpp"
#include "mapped_drive.hpp"

namespace lidar_mapping::tools {
namespace {

namespace fs = std::filesystem;
using test::Words;

class BuildMap : public test::MappedDrive {
 protected:
  /// Its map of the session, as the options want it.
  PointCloud built(const Words& options) {
    const fs::path target = folder_.path() / std::to_string(++runs_);
    EXPECT_EQ(run("build_map", joined({whole(), "-o", target}, options)), 0);
    return session::read_pcd(target / "map.pcd");
  }

  int runs_ = 0;
};

TEST_F(BuildMap, TakesFormatsInCapitals) {
  EXPECT_GT(built({"--formats", "PCD,Png"}).size(), 1000U);
  EXPECT_TRUE(fs::exists(folder_.path() / "1" / "top_view.png"));
}

/// The map had holes, and nobody said so.
TEST_F(BuildMap, SaysHowManyKeyFramesHaveNoCloud) {
  const fs::path holed = folder_.path() / "holed";
  fs::copy(whole(), holed, fs::copy_options::recursive);
  const session::Session session = opened(holed);
  fs::remove(session.clouds().file(1));
  std::ofstream(session.clouds().file(2)) << "damaged";
  EXPECT_EQ(run("build_map", {holed, "-o", folder_.path() / "1", "--formats", "pcd"}), 0);
  EXPECT_TRUE(has_said("2 of them without cloud"));
  EXPECT_GT(built({"--formats", "pcd"}).size(), 1000U);
  EXPECT_FALSE(has_said("without cloud"));
}

TEST_F(BuildMap, CropsToABox) {
  const PointCloud whole_map = built({"--formats", "pcd"});
  const PointCloud part =
      built({"--formats", "pcd", "--crop", "-10", "-5", "0.5", "20", "8.5", "3"});
  ASSERT_GT(part.size(), 100U);
  std::size_t inside = 0;
  const auto is_in = [](const Point& p, float margin) {
    return p.x > -10.0F + margin && p.x < 20.0F - margin && p.y > -5.0F + margin &&
           p.y < 8.5F - margin && p.z > 0.5F + margin && p.z < 3.0F - margin;
  };
  for (const Point& point : whole_map.points) inside += is_in(point, 0.0F) ? 1 : 0;
  for (const Point& point : part.points) EXPECT_TRUE(is_in(point, -1e-4F));
  EXPECT_NEAR(static_cast<double>(part.size()), static_cast<double>(inside),
              0.1 * static_cast<double>(inside));

  EXPECT_EQ(run("build_map", {whole(), "--crop", "10", "0", "0", "5", "1", "1"}), 1);
  EXPECT_TRUE(has_said("is empty; give the lower corner first"));
  const Words far = {whole(), "-o", folder_.path() / "none", "--crop", "9000", "0", "0", "9001",
                     "1",     "1"};
  EXPECT_EQ(run("build_map", far), 1);
  EXPECT_TRUE(has_said("no point of the map lies in the box"));
}

TEST_F(BuildMap, TakesTheKeyFramesUpToADate) {
  const auto key_frames = opened(whole()).key_frames();
  const std::string day = iso_date(key_frames.back().stamp).substr(0, 10);
  EXPECT_EQ(built({"--formats", "pcd", "--as-of", day}).size(), built({"--formats", "pcd"}).size());
  const std::string second = iso_date(key_frames[key_frames.size() / 2].stamp);
  const std::size_t half = built({"--formats", "pcd", "--as-of", second}).size();
  EXPECT_LT(half, built({"--formats", "pcd"}).size());
  EXPECT_TRUE(has_said(" key frames"));

  const fs::path none = folder_.path() / "none";
  EXPECT_EQ(run("build_map", {whole(), "-o", none, "--as-of", "1999-12-31"}), 1);
  EXPECT_TRUE(
      has_said("no key frame is as old as the date of --as-of; the first one is of " + day));
  EXPECT_EQ(run("build_map", {whole(), "-o", none, "--as-of", "yesterday"}), 1);
  EXPECT_TRUE(has_said("'yesterday' is not a date"));
}

TEST_F(BuildMap, CropsMovingObjectsToo) {
  const auto removed = [&](const Words& options) {
    built(joined({"--formats", "pcd", "--save-removed"}, options));
    return session::read_pcd(folder_.path() / std::to_string(runs_) / "moving_objects.pcd");
  };
  const PointCloud all = removed({});
  std::vector<float> xs;
  for (const Point& point : all.points) xs.push_back(point.x);
  ASSERT_GT(xs.size(), 20U);
  std::nth_element(xs.begin(), xs.begin() + xs.size() / 2, xs.end());
  const float middle = xs[xs.size() / 2] + 1e-3F;
  const PointCloud part =
      removed({"--crop", "-1000", "-1000", "-1000", std::to_string(middle), "1000", "1000"});
  for (const Point& point : part.points) EXPECT_LT(point.x, middle + 1e-3F);
  EXPECT_NEAR(static_cast<double>(part.size()), 0.5 * static_cast<double>(all.size()),
              0.1 * static_cast<double>(all.size()));
}

TEST_F(BuildMap, CountsNoPointsWhereNoneAreNeeded) {
  const fs::path target = folder_.path() / "marks";
  ASSERT_EQ(run("build_map", {whole(), "-o", target, "--formats", "geojson"}), 0);
  EXPECT_FALSE(has_said("0 points"));
}

/// What the page and a GIS show of this drive; the other tests of these formats have maps by hand.
TEST_F(BuildMap, WritesTilesOfLevelsAndLayersForAGis) {
  const fs::path target = folder_.path() / "gis";
  ASSERT_EQ(run("build_map", {whole(), "-o", target, "--formats", "ept,geojson,pcd"}), 0);
  const std::string reader = "python3 map/read_ept.py " + (target / "ept").string();
  EXPECT_EQ(std::system(reader.c_str()), 0);
  EXPECT_FALSE(fs::exists(target / "ept" / "index.html")) << "nobody asked for the page";
  const auto ept = nlohmann::json::parse(test::content_of(target / "ept" / "ept.json"));
  EXPECT_EQ(ept["points"], session::read_pcd(target / "map.pcd").size());
  const auto session = opened(whole());
  const auto& time = ept["schema"][5];
  ASSERT_EQ(time["name"], "GpsTime");
  EXPECT_EQ(time["minimum"], to_seconds(session.key_frames().front().stamp));
  ASSERT_TRUE(session.datum());
  const auto way = nlohmann::json::parse(test::content_of(target / "trajectory.geojson"));
  EXPECT_EQ(way["features"][0]["geometry"]["coordinates"].size(), session.key_frame_count());
}

/// What optimize_session has said of the graph, without the time that it took.
std::string figures_in(const std::string& said) {
  const std::size_t begin = said.find("key frames ");
  const std::size_t end = said.find(", ", said.find("cost "));
  EXPECT_NE(end, std::string::npos) << said;
  return said.substr(begin, end - begin);
}

TEST_F(BuildMap, OptimizesASessionInPlaceAsIntoAnotherFolder) {
  const fs::path session = folder_.path() / "session";
  fs::copy(whole(), session, fs::copy_options::recursive);
  ASSERT_EQ(run("optimize_session", {session, "--output", folder_.path() / "aside"}), 0);
  const std::string aside = figures_in(said());
  ASSERT_EQ(run("optimize_session", {session}), 0);
  EXPECT_EQ(figures_in(said()), aside);
  const session::RevisionRecord stored = opened(session).revisions().back();
  EXPECT_GT(stored.cost_before, stored.cost_after);
  EXPECT_GT(stored.seconds, 0.0);
  EXPECT_EQ(opened(session).poses().revision, stored.revision);
}

/// Positions were received, and the session has a datum, but the poses do not lie there.
TEST_F(BuildMap, WritesLocalMetresIfTheGraphDoesNotUseGnss) {
  const fs::path session = folder_.path() / "without_gnss";
  fs::copy(whole(), session, fs::copy_options::recursive);
  ASSERT_EQ(run("optimize_session", {session, "--use-gnss", "false"}), 0);
  ASSERT_TRUE(opened(session).datum());
  const fs::path target = folder_.path() / "local";
  ASSERT_EQ(run("build_map", {session, "-o", target, "--formats", "las,geojson"}), 0);
  EXPECT_TRUE(fs::exists(target / "trajectory_local_metres.geojson"));
  EXPECT_FALSE(fs::exists(target / "trajectory.geojson"));
  const std::string las = test::content_of(target / "map.las");
  ASSERT_GT(las.size(), 227U);
  std::uint32_t records = 0;
  double max_x = 0.0;
  std::memcpy(&records, las.data() + 100, sizeof records);
  std::memcpy(&max_x, las.data() + 179, sizeof max_x);
  EXPECT_EQ(records, 0U) << "a VLR would tell a coordinate system";
  EXPECT_LT(std::abs(max_x), 1000.0) << "an easting has six digits";
  // What GNSS and IMU measured lies there.
  const fs::path truth = session / "trajectory" / "ground_truth.tum";
  ASSERT_EQ(run("build_map", {session, "-o", target, "--formats", "geojson", "--poses", truth}), 0);
  EXPECT_TRUE(fs::exists(target / "trajectory.geojson"));
}

TEST_F(BuildMap, RefusesCellsSmallerThanTheVoxels) {
  EXPECT_EQ(run("build_map", {whole(), "--formats", "grid", "--cell", "0.1"}), 1);
  EXPECT_TRUE(has_said("smaller than the map's voxels"));
}

/// To see by eye whether extrinsics and receivers are right.
TEST_F(BuildMap, PlacesKeyFramesWhereATrajectorySays) {
  const PointCloud own = built({"--formats", "pcd"});
  Trajectory moved;
  for (const KeyFramePose& pose : opened(whole()).poses().poses) {
    moved.poses.push_back({pose.stamp, pose.T_map_base});
    moved.poses.back().pose.translation.z() += 100.0;
  }
  const fs::path file = folder_.path() / "moved.tum";
  std::ofstream(file) << to_tum(moved);
  const PointCloud lifted = built({"--formats", "pcd", "--poses", file});
  EXPECT_NEAR(static_cast<double>(lifted.size()), static_cast<double>(own.size()),
              0.02 * static_cast<double>(own.size()));
  const auto lowest = [](const PointCloud& map) {
    float z = 1e9F;
    for (const Point& point : map.points) z = std::min(z, point.z);
    return z;
  };
  EXPECT_NEAR(lowest(lifted), lowest(own) + 100.0F, 0.3F);
  const std::size_t all = moved.poses.size();
  moved.poses.resize(5);
  std::ofstream(file) << to_tum(moved);
  built({"--formats", "pcd", "--poses", file});
  EXPECT_TRUE(has_said("only 5 of " + std::to_string(all) + " key frames have a pose: "));
  for (StampedPose& pose : moved.poses) pose.stamp += from_seconds(1e6);
  std::ofstream(file) << to_tum(moved);
  EXPECT_EQ(run("build_map", {whole(), "-o", folder_.path() / "none", "--poses", file}), 1);
  EXPECT_TRUE(has_said("is it of this drive?"));
}

TEST_F(BuildMap, PutsAllScansIntoTheMap) {
  const std::size_t key_frames = built({"--formats", "pcd", "--resolution", "0.05"}).size();
  const std::size_t scans =
      built({"--formats", "pcd", "--resolution", "0.05", "--scans", bag()}).size();
  EXPECT_GT(scans, 3 * key_frames / 2);
  EXPECT_TRUE(has_said(" scans\n"));
  const std::size_t full = built({"--formats", "pcd", "--resolution", "0.05", "--every", "2",
                                  "--scan-resolution", "0", "--scans", bag()})
                               .size();
  EXPECT_GT(full, key_frames);
}

}  // namespace
}  // namespace lidar_mapping::tools
