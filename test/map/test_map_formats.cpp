// SPDX-License-Identifier: BSD-3-Clause
// Tests each row of the table of formats.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/write_products.hpp"

#include "box_street.hpp"
#include "error_text.hpp"
#include "file_content.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::map {
namespace {

/// One key frame: a square of ground of 10 m with a wall, a point every 10 cm.
class OneKeyFrame : public CloudSource {
 public:
  PointCloudPtr cloud(KeyFrameIndex) override {
    auto cloud = std::make_shared<PointCloud>();
    for (int i = 0; i < 100; ++i) {
      for (int j = 0; j < 100; ++j) {
        const float u = 0.1F * static_cast<float>(i) + 0.05F;
        const float v = 0.1F * static_cast<float>(j) + 0.05F;
        cloud->points.push_back({u, v, 0.0F, 1.0F});
        if (j < 30) cloud->points.push_back({u, 10.0F, v, 1.0F});
      }
    }
    return cloud;
  }

  const KeyFramePoses poses{1, true, {{0, 0, Pose::Identity()}}};
};

/// All but those that lack an optional package on this machine.
std::vector<std::string> writable_formats() {
  std::vector<std::string> formats;
  for (const std::string& format : product_formats()) {
    const std::string obstacle = obstacle_to(format);
    if (obstacle.empty()) {
      formats.push_back(format);
    } else {
      std::printf("%s is NOT tested: %s\n", format.c_str(), obstacle.c_str());
    }
  }
  return formats;
}

class MapFormats : public testing::Test {
 protected:
  Products written(const std::vector<std::string>& formats) {
    ProductOptions options;
    options.formats = formats;
    options.name = "site";
    options.p_base_sensor = Eigen::Vector3d(5.0, 5.0, 2.0);
    return write_products(source_.poses, source_, {}, options, folder_.path());
  }

  OneKeyFrame source_;
  const test::TemporaryFolder folder_;
};

TEST_F(MapFormats, WritesEachFormatAlone) {
  for (const std::string& format : writable_formats()) {
    const Products products = written({format});
    ASSERT_FALSE(products.files.empty()) << format;
    // It is made from the session alone.
    const bool has_points = format != "geojson" && format != "changes";
    EXPECT_EQ(products.points > 1000U, has_points) << format;
    for (const auto& file : products.files) EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
}

TEST_F(MapFormats, WritesAllFormatsTogetherAndEachFileOnce) {
  std::vector<std::filesystem::path> files = written(writable_formats()).files;
  std::sort(files.begin(), files.end());
  EXPECT_EQ(std::adjacent_find(files.begin(), files.end()), files.end());
  EXPECT_GE(files.size(), writable_formats().size());
}

TEST_F(MapFormats, SingleFilesHaveNameAndFormat) {
  ASSERT_FALSE(single_file_formats().empty());
  for (const std::string& format : single_file_formats()) {
    written({format});
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / ("site." + format))) << format;
  }
}

// Two merged drives may begin at the same instant, as simulated ones do.
TEST_F(MapFormats, DistinguishDrivesOfEqualStamps) {
  KeyFramePoses poses = source_.poses;
  poses.poses.push_back({1, 0, Pose{Eigen::Quaterniond::Identity(), {50.0, 0.0, 0.0}}});
  ProductOptions options;
  options.formats = {"ept"};
  options.marks = [] {
    DriveMarks marks;
    marks.path.push_back({0, 0, 0, Eigen::Vector3d(0.0, 0.0, 0.0)});
    marks.path.push_back({1, 1, 0, Eigen::Vector3d(50.0, 0.0, 0.0)});
    return marks;
  };
  write_products(poses, source_, {}, options, folder_.path());
  const auto ept = nlohmann::json::parse(test::content_of(folder_.path() / "ept" / "ept.json"));
  std::size_t found = 0;
  for (const nlohmann::json& dimension : ept["schema"]) {
    if (dimension["name"].get<std::string>() != "PointSourceId") continue;
    ++found;
    EXPECT_EQ(dimension["minimum"].get<double>(), 0.0);
    EXPECT_EQ(dimension["maximum"].get<double>(), 1.0);
  }
  EXPECT_EQ(found, 1U);
}

TEST_F(MapFormats, ChangesNeedTheRaysOfTheLidar) {
  ProductOptions options;
  options.formats = {"changes"};
  EXPECT_THROW(write_products(source_.poses, source_, {}, options, folder_.path()), InputError);
}

TEST_F(MapFormats, RefuseParametersThatDoNotFitBeforeAFileIsWritten) {
  MapConfig config;
  config.grid_cell = config.resolution / 2.0;
  EXPECT_NO_THROW(check_formats({"pcd"}, config));
  EXPECT_THROW(check_formats({"pcd", "GRID"}, config), InputError);
  ProductOptions options;
  options.formats = {"pcd", "grid"};
  EXPECT_THROW(write_products(source_.poses, source_, config, options, folder_.path()), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(MapFormats, NeedPoints) {
  class Nothing : public CloudSource {
   public:
    PointCloudPtr cloud(KeyFrameIndex) override { return nullptr; }
  } nothing;
  for (const std::string& format : writable_formats()) {
    if (format == "geojson" || format == "changes") continue;
    ProductOptions options;
    options.formats = {format};
    EXPECT_THROW(write_products(source_.poses, nothing, {}, options, folder_.path()), Error)
        << format;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(MapFormats, HelpAndErrorsListAllFormats) {
  const std::string problem = test::error_text<InputError>([&] { written({"shp"}); });
  for (const std::string& format : product_formats()) {
    EXPECT_NE(product_format_help().find(format), std::string::npos) << format;
    EXPECT_NE(problem.find(format), std::string::npos) << format << " is not in: " << problem;
  }
}

/// The first line of the file that contains this text, from there on.
std::string line_from(const std::string& path, const std::string& text) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto at = line.find(text);
    if (at != std::string::npos) return line.substr(at);
  }
  return {};
}

/// The words of small letters between two texts.
std::set<std::string> words_between(const std::string& line, const std::string& begin,
                                    const std::string& end) {
  const auto at = line.find(begin);
  if (at == std::string::npos) return {};
  const auto first = at + begin.size();
  const std::string list = line.substr(first, line.find(end, first) - first);
  const std::regex word("[a-z]+");
  return {std::sregex_token_iterator(list.begin(), list.end(), word), {}};
}

// These are written by hand, each in one line.
TEST(MapFormatLists, NameAllFormats) {
  const std::set<std::string> lists[] = {
      words_between(line_from("../srv/SaveMap.srv", "string[] formats"), "#", ";"),
      words_between(line_from("../scripts/city/project.py", "FORMATS = "), "(", ")"),
      words_between(line_from("../doc/glossary.md", "| `formats` |"), "SaveMap:", "|"),
      words_between(line_from("../doc/reference/commands.md", "| `build_map SESSION"), "--formats",
                    "]"),
  };
  for (const std::set<std::string>& list : lists) {
    for (const std::string& format : product_formats())
      EXPECT_EQ(list.count(format), 1U)
          << format << " is not in list " << (&list - lists) << " of " << list.size() << " words";
  }
  for (const std::string& format : single_file_formats())
    EXPECT_NE(line_from("../src/report/report_origin.cpp", "map/map." + format), "") << format;
}

TEST(MapProducts, CountNoOutdatedPointsWhereTheseAreKept) {
  // The car leaves before the next day.
  moving_objects::TwoDays days(12, 1.5, {{12.0, -5.5, 0.0}, {16.0, -3.8, 1.5}}, false);
  const test::TemporaryFolder folder;
  ProductOptions options;
  options.formats = {"changes"};
  options.p_base_sensor = days.p_base_sensor;
  EXPECT_GT(write_products(days.poses, days, {}, options, folder.path()).outdated, 100U);
  options.keep_outdated = true;
  const Products kept = write_products(days.poses, days, {}, options, folder.path());
  EXPECT_EQ(kept.visits, 2U);
  EXPECT_EQ(kept.outdated, 0U);
}

}  // namespace
}  // namespace lidar_mapping::map
