// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "map_viewer/map_order.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::ros_border {
namespace {

namespace fs = std::filesystem;

SaveMap::Request request_for(const fs::path& destination) {
  SaveMap::Request request;
  request.destination = destination.string();
  return request;
}

std::string problem_of(const SaveMap::Request& request) {
  return test::error_text<Error>([&] { map_order(request); });
}

TEST(MapOrder, NamesOneFile) {
  const test::TemporaryFolder folder;
  SaveMap::Request request = request_for(folder.path() / "town" / "old.town.PCD");
  request.utm = true;
  const MapOrder order = map_order(request);
  EXPECT_EQ(order.directory, folder.path() / "town");
  EXPECT_EQ(order.options.name, "old.town");
  EXPECT_EQ(order.options.formats, std::vector<std::string>{"pcd"});
  EXPECT_EQ(order.place(), folder.path() / "town" / "old.town.pcd");
  EXPECT_TRUE(order.options.utm);
}

TEST(MapOrder, OverwritesNothing) {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.pcd", "b.pcd.utm", "c.yaml"}) {
    std::ofstream(folder.path() / name) << "x";
  }
  for (const char* name : {"a", "b", "c"}) {
    const std::string problem =
        problem_of(request_for(folder.path() / (std::string(name) + ".pcd")));
    EXPECT_NE(problem.find("is there already"), std::string::npos) << name << ": " << problem;
  }
}

TEST(MapOrder, SaysWhatDoesNotFit) {
  EXPECT_NE(problem_of(request_for("map.txt")).find("does not end in .pcd"), std::string::npos);
  EXPECT_NE(problem_of(request_for("maps/")).find("does not end in .pcd"), std::string::npos);
  SaveMap::Request both = request_for("map.pcd");
  both.directory = "maps";
  EXPECT_NE(problem_of(both).find("leave directory and formats empty"), std::string::npos);
  SaveMap::Request folder;
  folder.directory = "maps";
  EXPECT_EQ(map_order(folder).place(), fs::current_path() / "maps");
  EXPECT_TRUE(map_order({}).directory.empty());
}

}  // namespace
}  // namespace lidar_mapping::ros_border
