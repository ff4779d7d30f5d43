// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "file_content.hpp"
#include "gis/change_files.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

using moving_objects::Change;
using moving_objects::ChangeKind;
using moving_objects::Visit;
using test::content_of;

constexpr Stamp kDay = 86'400'000'000'000;
constexpr GeodeticDatum kDatum{49.0, 8.4, 110.0};

Change change(ChangeKind kind, std::uint32_t absent, std::uint32_t present) {
  Change result{kind, absent, present, {1.0, 2.0, 0.5}, {3.0, 2.5, 2.0}, {}};
  result.points.points = {{1.0F, 2.0F, 1.0F, 0.0F}, {2.0F, 2.0F, 1.5F, 0.0F}};
  return result;
}

class ChangeFiles : public testing::Test {
 protected:
  nlohmann::json written(const std::optional<GeodeticDatum>& datum) {
    const std::vector<Visit> visits = {
        {0, kDay / 4}, {kDay, kDay + kDay / 4}, {2 * kDay, 2 * kDay}};
    files_ =
        write_changes({change(ChangeKind::kAppeared, 0, 1), change(ChangeKind::kDisappeared, 2, 1)},
                      visits, datum, folder_.path());
    return nlohmann::json::parse(content_of(files_.front()));
  }

  test::TemporaryFolder folder_;
  Files files_;
};

TEST_F(ChangeFiles, NamePlaceSizeAndTime) {
  const nlohmann::json layer = written(std::nullopt);
  EXPECT_EQ(files_.front().filename(), "changes_local_metres.geojson");
  ASSERT_EQ(layer["features"].size(), 2U);
  const nlohmann::json& came = layer["features"][0]["properties"];
  EXPECT_EQ(came["kind"], "appeared");
  EXPECT_EQ(came["after"], "1970-01-01T06:00:00Z") << "the end of the visit without it";
  EXPECT_EQ(came["before"], "1970-01-02T00:00:00Z") << "the beginning of the visit with it";
  EXPECT_EQ(came["size_x_m"], 2.0);
  EXPECT_EQ(came["size_y_m"], 0.5);
  EXPECT_EQ(came["height_m"], 1.5);
  const nlohmann::json& went = layer["features"][1]["properties"];
  EXPECT_EQ(went["kind"], "disappeared");
  EXPECT_EQ(went["after"], "1970-01-02T06:00:00Z");
  EXPECT_EQ(went["before"], "1970-01-03T00:00:00Z");
  const nlohmann::json& ring = layer["features"][0]["geometry"]["coordinates"][0];
  ASSERT_EQ(ring.size(), 5U);
  EXPECT_EQ(ring[0], ring[4]);
  EXPECT_EQ(ring[2], nlohmann::json({3.0, 2.5, 0.5}));
}

TEST_F(ChangeFiles, AreInDegreesWhereThereIsADatum) {
  const nlohmann::json layer = written(kDatum);
  EXPECT_EQ(files_.front().filename(), "changes.geojson");
  const nlohmann::json& corner = layer["features"][0]["geometry"]["coordinates"][0][0];
  EXPECT_NEAR(corner[0].get<double>(), kDatum.longitude_deg, 1e-4);
  EXPECT_NEAR(corner[1].get<double>(), kDatum.latitude_deg, 1e-4);
}

TEST_F(ChangeFiles, HoldThePointsWithTheNumberOfTheirChange) {
  written(std::nullopt);
  ASSERT_EQ(files_.size(), 2U);
  pcl::PointCloud<pcl::PointXYZI> points;
  ASSERT_EQ(pcl::io::loadPCDFile(files_.back(), points), 0);
  ASSERT_EQ(points.size(), 4U);
  EXPECT_EQ(points[0].intensity, 1.0F);
  EXPECT_EQ(points[3].intensity, -2.0F) << "it has disappeared";
  EXPECT_EQ(points[3].getVector3fMap(), Eigen::Vector3f(2.0F, 2.0F, 1.5F));
}

TEST_F(ChangeFiles, AreAnEmptyLayerWhereNothingChanged) {
  written(std::nullopt);
  const Files files = write_changes({}, {}, std::nullopt, folder_.path());
  ASSERT_EQ(files.size(), 1U);
  EXPECT_TRUE(nlohmann::json::parse(content_of(files.front()))["features"].empty());
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "changes.pcd")) << "it is of another map";
}

}  // namespace
}  // namespace lidar_mapping::map
