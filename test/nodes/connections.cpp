// SPDX-License-Identifier: BSD-3-Clause
#include "connections.hpp"

#include <algorithm>
#include <vector>

#include <XmlRpc.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/network.h>
#include <ros/this_node.h>

namespace lidar_mapping::test {

namespace {

std::vector<std::string> nodes_at(XmlRpc::XmlRpcValue& topics, const std::string& topic) {
  std::vector<std::string> nodes;
  for (int i = 0; i < topics.size(); ++i) {
    if (static_cast<std::string>(topics[i][0]) != topic) continue;
    for (int k = 0; k < topics[i][1].size(); ++k) nodes.push_back(topics[i][1][k]);
  }
  return nodes;
}

/// Calls a function of the node's own interface (slave API).
bool ask(const std::string& node, const std::string& function, XmlRpc::XmlRpcValue& value) {
  XmlRpc::XmlRpcValue request, answer, uri;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, answer, uri, false)) return false;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return false;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  const bool answered = client.execute(function.c_str(), request[0], answer);
  if (!answered || answer.getType() != XmlRpc::XmlRpcValue::TypeArray || answer.size() < 3) {
    return false;
  }
  value = answer[2];
  return true;
}

/// Links of a node on a topic; direction "i" or "o".
std::size_t links_of(const std::string& node, const std::string& topic,
                     const std::string& direction) {
  XmlRpc::XmlRpcValue links;
  if (!ask(node, "getBusInfo", links)) return 0;
  std::size_t count = 0;
  for (int i = 0; i < links.size(); ++i) {
    const bool is_wanted = static_cast<std::string>(links[i][2]) == direction;
    if (is_wanted && static_cast<std::string>(links[i][4]) == topic) ++count;
  }
  return count;
}

}  // namespace

bool is_connected(const std::string& topic) {
  XmlRpc::XmlRpcValue state, lists;
  const XmlRpc::XmlRpcValue caller(ros::this_node::getName());
  if (!ros::master::execute("getSystemState", caller, state, lists, false)) return false;
  const std::string name = ros::names::resolve(topic);
  const std::vector<std::string> publishers = nodes_at(lists[0], name);
  const std::vector<std::string> subscribers = nodes_at(lists[1], name);
  return publishers.size() == 1 && !subscribers.empty() &&
         std::all_of(subscribers.begin(), subscribers.end(),
                     [&](const auto& node) { return links_of(node, name, "i") > 0; }) &&
         links_of(publishers.front(), name, "o") >= subscribers.size();
}

int process_of(const std::string& node) {
  XmlRpc::XmlRpcValue pid;
  return ask(ros::names::resolve(node), "getPid", pid) ? static_cast<int>(pid) : 0;
}

}  // namespace lidar_mapping::test
