#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <geometry_msgs/TwistStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/preprocessing/input_doctor.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

namespace lidar_mapping::tools {

namespace {

struct Topics {
  std::string points, imu, velocity, gnss;
};

struct Options {
  std::string bag;
  std::string config;
  std::string base_frame = "base_link";
  Topics topics;
};

/// The topic that was asked for, or the one of that type with most messages.
std::string topic_of(const rosbag::Bag& bag, const std::string& wanted, const std::string& type) {
  if (!wanted.empty()) return wanted;
  rosbag::View view(bag, rosbag::TypeQuery(type));
  std::string best;
  std::size_t most = 0;
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    const std::size_t size = rosbag::View(bag, rosbag::TopicQuery(connection->topic)).size();
    if (size > most) best = connection->topic;
    most = std::max(most, size);
  }
  return best;
}

class BagCheck {
 public:
  BagCheck(const Options& options, const preprocessing::PreprocessingConfig& config)
      : options_(options), config_(config), doctor_(config), bag_(options.bag) {
    Topics& topics = options_.topics;
    topics.points = topic_of(bag_, topics.points, "sensor_msgs/PointCloud2");
    topics.imu = topic_of(bag_, topics.imu, "sensor_msgs/Imu");
    topics.velocity = topic_of(bag_, topics.velocity, "geometry_msgs/TwistStamped");
    topics.gnss = topic_of(bag_, topics.gnss, "sensor_msgs/NavSatFix");
  }

  /// Prints a line per input and fault; true if there is no fault.
  bool run() {
    const Topics& t = options_.topics;
    rosbag::View view(bag_, rosbag::TopicQuery(std::vector<std::string>{
                                t.points, t.imu, t.velocity, t.gnss, "/tf", "/tf_static"}));
    for (const rosbag::MessageInstance& message : view) see(message);
    bool healthy = true;
    const std::string names[] = {t.points, t.imu, t.velocity, t.gnss};
    std::size_t index = 0;
    for (const auto& report : doctor_.report([this](const auto& f) { return T_base(f); })) {
      const std::string& name = names[index++];
      std::printf("%-9s %s%s%s\n", report.input.c_str(), name.c_str(), name.empty() ? "" : ": ",
                  report.found.c_str());
      for (const std::string& fault : report.faults) std::printf("  FAULT   %s\n", fault.c_str());
      healthy = healthy && report.faults.empty();
    }
    for (const std::string& problem : unreadable_) {
      std::printf("  FAULT   %s\n", problem.c_str());
      healthy = false;
    }
    return healthy;
  }

 private:
  void see(const rosbag::MessageInstance& message) {
    if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) return see(*cloud);
    if (const auto imu = message.instantiate<sensor_msgs::Imu>()) {
      return doctor_.see_imu(ros_border::from_message(*imu), imu->header.frame_id);
    }
    if (const auto velocity = message.instantiate<geometry_msgs::TwistStamped>()) {
      return doctor_.see_velocity(ros_border::from_message(*velocity), velocity->header.frame_id);
    }
    if (const auto fix = message.instantiate<sensor_msgs::NavSatFix>()) {
      return doctor_.see_gnss(ros_border::from_message(*fix), fix->header.frame_id);
    }
    if (const auto frames = message.instantiate<tf2_msgs::TFMessage>()) {
      for (geometry_msgs::TransformStamped transform : frames->transforms) {
        transform.header.frame_id = ros_border::frame_name(transform.header.frame_id);
        transform.child_frame_id = ros_border::frame_name(transform.child_frame_id);
        frames_.setTransform(transform, "bag", message.getTopic() == "/tf_static");
      }
    }
  }

  void see(const sensor_msgs::PointCloud2& message) try {
    doctor_.see_scan(ros_border::summary_of(message, ros_border::decode(message, config_)));
  } catch (const InputError& error) {
    unreadable_.insert(error.what());
  }

  std::optional<Pose> T_base(const std::string& frame) const {
    if (frame == options_.base_frame) return Pose::Identity();
    try {
      return ros_border::from_message(
          frames_.lookupTransform(options_.base_frame, frame, ros::Time(0)).transform);
    } catch (const tf2::TransformException&) {
      return std::nullopt;
    }
  }

  Options options_;
  preprocessing::PreprocessingConfig config_;
  preprocessing::InputDoctor doctor_;
  rosbag::Bag bag_;
  tf2::BufferCore frames_{ros::Duration(1e6)};
  std::set<std::string> unreadable_;
};

}  // namespace

}  // namespace lidar_mapping::tools

int main(int argc, char** argv) {
  using namespace lidar_mapping;
  tools::Options options;
  CLI::App app{"Looks at the sensors' messages in a bag and says what is wrong with them"};
  app.add_option("bag", options.bag, "bag to look at")->required();
  app.add_option("--config", options.config, "preprocessing.yaml to judge by");
  app.add_option("--base-frame", options.base_frame, "frame of the vehicle");
  app.add_option("--points", options.topics.points, "topic (found by its type if left out)");
  app.add_option("--imu", options.topics.imu, "topic");
  app.add_option("--velocity", options.topics.velocity, "topic");
  app.add_option("--gnss", options.topics.gnss, "topic");
  CLI11_PARSE(app, argc, argv);
  try {
    using Config = preprocessing::PreprocessingConfig;
    const Config config =
        options.config.empty() ? Config() : config::load_file<Config>(options.config);
    return tools::BagCheck(options, config).run() ? 0 : 1;
  } catch (const rosbag::BagException& error) {
    std::fprintf(stderr, "cannot read the bag %s: %s\n", options.bag.c_str(), error.what());
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 2;
}
