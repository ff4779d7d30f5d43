// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/front_end/front_end_config.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/parameters.hpp"

#include "error_text.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Config = NodeConfig<front_end::FrontEndConfig>;

Config load(XmlRpc::XmlRpcValue values) {
  return config::load<Config>({{"/front_end_node", from_xmlrpc(values)}});
}

std::string problem_of(const XmlRpc::XmlRpcValue& values) {
  return test::error_text<ConfigError>([&] { load(values); });
}

TEST(FromXmlRpc, KeepsEveryType) {
  XmlRpc::XmlRpcValue values;
  values["flag"] = true;
  values["count"] = 3;
  values["length"] = 0.5;
  values["word"] = "map";
  values["group"]["list"][0] = 1;
  values["group"]["list"][1] = 2.5;
  const auto leaves = config::flattened(from_xmlrpc(values));
  EXPECT_EQ(std::get<bool>(leaves.at("flag").data), true);
  EXPECT_EQ(std::get<int>(leaves.at("count").data), 3);
  EXPECT_EQ(std::get<double>(leaves.at("length").data), 0.5);
  EXPECT_EQ(std::get<std::string>(leaves.at("word").data), "map");
  EXPECT_EQ(config::to_string(leaves.at("group/list")), "[1, 2.5]");
}

TEST(FromXmlRpc, ReadsNumbersThatRosparamTakesForWords) {
  EXPECT_EQ(std::get<double>(from_xmlrpc(XmlRpc::XmlRpcValue("1e-6")).data), 1e-6);
  EXPECT_EQ(std::get<double>(from_xmlrpc(XmlRpc::XmlRpcValue("-2.5E3")).data), -2500.0);
  EXPECT_EQ(std::get<std::string>(from_xmlrpc(XmlRpc::XmlRpcValue("1e999")).data), "1e999");
  EXPECT_EQ(std::get<std::string>(from_xmlrpc(XmlRpc::XmlRpcValue("e3")).data), "e3");
}

TEST(NodeConfig, HasTheFieldsOfTheStageAndOfTheNode) {
  XmlRpc::XmlRpcValue values;
  values["key_frame_distance"] = 3;
  values["base_frame"] = "vehicle";
  const Config config = load(values);
  EXPECT_EQ(config.stage.key_frame_distance, 3.0);
  EXPECT_EQ(config.node.base_frame, "vehicle");
  EXPECT_EQ(config.node.odom_frame, "odom");
}

// Wrong values crashed later; misspelt keys had no effect.
TEST(NodeConfig, NamesEveryProblemInALineOfItsOwn) {
  XmlRpc::XmlRpcValue values;
  values["key_frame_distance"] = -1.0;
  values["key_frame_angel"] = 0.3;
  values["queue_size"] = 0;
  values["base_frame"] = "/base_link";
  const std::string problem = problem_of(values);
  EXPECT_EQ(std::count(problem.begin(), problem.end(), '\n'), 3) << problem;
  EXPECT_NE(problem.find("/front_end_node: key_frame_distance: -1 is out of range"),
            std::string::npos);
  EXPECT_NE(problem.find("did you mean 'key_frame_angle'?"), std::string::npos);
  EXPECT_NE(problem.find("queue_size: 0 is out of range"), std::string::npos);
  EXPECT_NE(problem.find("'/base_link' starts with a slash"), std::string::npos);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
