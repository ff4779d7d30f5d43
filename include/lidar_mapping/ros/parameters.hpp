// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include "lidar_mapping/config/value.hpp"

namespace lidar_mapping::ros_border {

/// A parameter as a configuration value. Numbers such as 1e-6, which the YAML reader of rosparam
/// takes for words, become numbers again. Throws ConfigError for binary data and dates.
config::Value from_xmlrpc(const XmlRpc::XmlRpcValue& value);

/// The groups that an overlay may have: those of the stages, and `nodes` for what all nodes share.
std::vector<std::string> overlay_groups();

/// The parameters of a stage on the parameter server, read once, in growing precedence: the group
/// `nodes` beside the node with what all nodes share, and that of the overlays; the node's private
/// parameters, and the group of the stage in the overlays. Launch files load these into the groups
/// overlays/sensor and overlays/preset beside the node; the latter has priority. Throws ConfigError
/// if an overlay has a group that no stage has.
std::vector<config::Source> parameter_sources(const ros::NodeHandle& node,
                                              const ros::NodeHandle& private_node,
                                              const std::string& stage);

/// Stores the effective configuration on the parameter server, from where the session copies it:
/// effective_configuration/STAGE, a YAML text.
void publish_effective_configuration(const ros::NodeHandle& node, const std::string& stage,
                                     const std::string& yaml);
/// The effective configurations of all nodes: YAML texts by stage.
std::map<std::string, std::string> effective_configurations(const ros::NodeHandle& node);

}  // namespace lidar_mapping::ros_border
