#include "lidar_mapping/ros/topic_choice.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/common/errors.hpp"

#include "point_fields.hpp"

namespace lidar_mapping::ros_border {

namespace {

using Bags = std::vector<const rosbag::Bag*>;

bool is_own_output(const std::string& topic) {
  const std::vector<std::string>& own = own_outputs();
  const std::string name = topic.substr(topic.find_last_of('/') + 1);
  return std::find(own.begin(), own.end(), name) != own.end();
}

/// Number of messages of each topic of that type.
std::map<std::string, std::size_t> topics_of(const Bags& bags, const std::string& type) {
  std::map<std::string, std::size_t> sizes;
  for (const rosbag::Bag* bag : bags) {
    rosbag::View view(*bag, rosbag::TypeQuery(type));
    std::map<std::string, std::size_t> here;
    for (const auto* connection : view.getConnections()) {
      if (!is_own_output(connection->topic)) here[connection->topic] = 0;
    }
    for (auto& [topic, size] : here) {
      sizes[topic] += rosbag::View(*bag, rosbag::TopicQuery(topic)).size();
    }
  }
  return sizes;
}

sensor_msgs::PointCloud2ConstPtr first_cloud(const Bags& bags, const std::string& topic) {
  for (const rosbag::Bag* bag : bags) {
    rosbag::View view(*bag, rosbag::TopicQuery(topic));
    if (view.size() > 0) return view.begin()->instantiate<sensor_msgs::PointCloud2>();
  }
  return nullptr;
}

/// What the fields of a cloud say of its sensor; the larger, the surer it is a LiDAR.
enum class Kind { kUnknown, kReflecting, kScanning };

Kind kind_of(const sensor_msgs::PointCloud2& cloud) try {
  if (find_any_field(cloud, kTimeNames) || find_field(cloud, "ring")) return Kind::kScanning;
  return find_any_field(cloud, kIntensityNames) ? Kind::kReflecting : Kind::kUnknown;
} catch (const InputError&) {
  return Kind::kUnknown;
}

}  // namespace

const std::vector<std::string>& own_outputs() {
  static const std::vector<std::string> names = {"synced_cloud",   "current_scan",    "local_map",
                                                 "global_map",     "synced_imu",      "synced_gnss",
                                                 "gnss_datum",     "synced_velocity", "laser_odom",
                                                 "optimized_odom", "ground_truth"};
  return names;
}

std::string busiest_topic(const Bags& bags, const std::string& type) {
  const auto sizes = topics_of(bags, type);
  const auto most = std::max_element(
      sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == sizes.end() ? std::string() : most->first;
}

std::vector<std::string> cloud_topics(const Bags& bags) {
  using Candidate = std::tuple<Kind, std::size_t, std::string>;
  std::vector<Candidate> candidates;
  for (const auto& [topic, size] : topics_of(bags, "sensor_msgs/PointCloud2")) {
    const auto cloud = first_cloud(bags, topic);
    if (!cloud) continue;
    candidates.emplace_back(kind_of(*cloud), size * cloud->data.size(), topic);
  }
  std::sort(candidates.rbegin(), candidates.rend());
  std::vector<std::string> topics;
  for (const Candidate& candidate : candidates) topics.push_back(std::get<2>(candidate));
  return topics;
}

}  // namespace lidar_mapping::ros_border
