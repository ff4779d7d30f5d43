// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/topic_choice.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <tuple>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"

#include "clouds/time_fields.hpp"
#include "inputs/odometry_choice.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Kind of sensor by the cloud's fields; a larger value is more likely a LiDAR.
enum class Kind { kUnknown, kReflecting, kScanning, kTimed };

Kind kind_of(const RecordedCloud& recorded) try {
  if (recorded.holds_packets()) return Kind::kTimed;
  const CloudView cloud = recorded.view();
  if (time_fields(cloud)) return Kind::kTimed;
  if (find_field(cloud, "ring") != nullptr) return Kind::kScanning;
  return find_any_field(cloud, kIntensityNames) ? Kind::kReflecting : Kind::kUnknown;
} catch (const InputError&) {
  return Kind::kUnknown;
}

/// Throws InputError if the messages of a requested topic have another definition than is read.
void check_definition(const std::string& name, const BagSet& bags) {
  for (const BagTopic& topic : bags.topics()) {
    if (topic.name != name) continue;
    const std::string problem = foreign_definition(topic.type, topic.md5sum);
    if (!problem.empty()) throw InputError(name + " holds " + problem + "; " + kForeignRemedy);
  }
}

/// Checks that a requested topic exists; without a request takes the usual topic if it exists.
void resolve_topic(std::string& wanted, const std::string& usual,
                   const std::vector<std::string>& types, const BagSet& bags) {
  if (wanted.empty()) {
    if (bags.has(usual, types)) wanted = usual;
  } else if (!bags.has(wanted, types)) {
    throw InputError("there is no topic " + wanted + " of type " + joined(types, " or ") +
                     " in the bags; rosbag info shows what there is");
  }
}

/// "/a,/b": the main LiDAR's topic, and those of the others.
void split_points(SensorTopics& wanted) {
  std::istringstream names(std::exchange(wanted.points, {}));
  for (std::string name; std::getline(names, name, ',');) {
    name.erase(0, name.find_first_not_of(' '));
    if (name.empty()) continue;
    if (name == wanted.points || contains(wanted.other_points, name)) {
      throw InputError("--points names " + name + " twice; name each LiDAR once");
    }
    if (wanted.points.empty()) {
      wanted.points = name;
    } else {
      wanted.other_points.push_back(name);
    }
  }
}

}  // namespace

const std::vector<std::string>& own_outputs() {
  static const std::vector<std::string> names = {
      "synced_cloud",          "current_scan",  "local_map",      "global_map",   "floor_points",
      "floor_filtered_points", "synced_imu",    "synced_gnss",    "gnss_datum",   "synced_velocity",
      "synced_inputs",         "laser_odom",    "optimized_odom", "ground_truth", "localized_odom",
      "localization_map",      "localized_scan"};
  return names;
}

bool is_own_output(const std::string& topic) {
  return contains(own_outputs(), topic.substr(topic.find_last_of('/') + 1));
}

std::optional<RecordedCloud> first_cloud(const BagSet& bags, const std::string& topic) {
  BagStream messages = bags.messages_of({topic});
  while (const auto message = messages.next()) {
    try {
      if (auto cloud = read_cloud(*message)) return cloud;
    } catch (const ros::Exception&) {
      continue;
    }
  }
  return std::nullopt;
}

std::vector<std::string> topics_of_type(const BagSet& bags, const std::string& type) {
  std::vector<BagTopic> topics = bags.topics();
  std::stable_sort(topics.begin(), topics.end(),
                   [](const BagTopic& a, const BagTopic& b) { return a.messages > b.messages; });
  std::vector<std::string> names;
  for (const BagTopic& topic : topics) {
    if (topic.type == type && !is_own_output(topic.name)) names.push_back(topic.name);
  }
  return names;
}

std::vector<std::string> cloud_topics(const BagSet& bags) {
  using Candidate = std::tuple<Kind, std::size_t, std::string>;
  std::vector<Candidate> candidates;
  for (const BagTopic& topic : bags.topics()) {
    if (!is_cloud(topic.type, topic.md5sum) || is_own_output(topic.name)) continue;
    const auto cloud = first_cloud(bags, topic.name);
    if (!cloud) continue;
    candidates.emplace_back(kind_of(*cloud), topic.messages * cloud->data.size, topic.name);
  }
  std::sort(candidates.rbegin(), candidates.rend());
  std::vector<std::string> topics;
  for (const Candidate& candidate : candidates) topics.push_back(std::get<2>(candidate));
  return topics;
}

SensorTopics topics_in(const BagSet& bags, SensorTopics wanted) {
  split_points(wanted);
  for (std::string& other : wanted.other_points) {
    resolve_topic(other, "", cloud_type_names(), bags);
    check_definition(other, bags);
  }
  resolve_topic(wanted.points, "/kitti/velo/pointcloud", cloud_type_names(), bags);
  check_definition(wanted.points, bags);
  resolve_topic(wanted.imu, kUsualImu, {"sensor_msgs/Imu"}, bags);
  resolve_topic(wanted.velocity, "/kitti/oxts/gps/vel", VelocityMessages::types(), bags);
  resolve_topic(wanted.gnss, "/kitti/oxts/gps/fix", GnssMessages::types(), bags);
  const auto fill = [](std::string& topic, const std::vector<std::string>& found) {
    if (topic.empty() && !found.empty()) topic = found.front();
  };
  fill(wanted.points, cloud_topics(bags));
  fill(wanted.imu, topics_of_type(bags, "sensor_msgs/Imu"));
  fill(wanted.velocity, topics_of_type(bags, VelocityMessages::types().front()));
  if (wanted.velocity.empty()) wanted.velocity = odometry_with_twist(bags);
  for (const std::string& type : GnssMessages::types()) {
    fill(wanted.gnss, topics_of_type(bags, type));
  }
  return wanted;
}

}  // namespace lidar_mapping::ros_border
