#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/ros/cloud_conversions.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/transforms.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Scans that wait for other sensors leave as they are when nothing has come for so long.
constexpr std::chrono::milliseconds kIdle{1000};
/// IMUs send ten times as often as LiDARs and more.
constexpr int kSamplesPerScan = 20;

}  // namespace

/// Subscribed: points, imu, velocity, gnss, tf. Published: synced_cloud, synced_imu,
/// synced_velocity, synced_gnss, all with the stamp of their scan.
class PreprocessingNode {
 public:
  using Config = NodeConfig<preprocessing::PreprocessingConfig>;

  PreprocessingNode(const Config& config, NodeContext& context);

 private:
  void advertise();
  void subscribe_sensors();
  void publish(const std::vector<preprocessing::SyncedScan>& scans);
  void publish(const preprocessing::SyncedScan& scan);
  void report();

  Config config_;
  NodeContext& context_;
  SensorFrames frames_;
  preprocessing::Preprocessor stage_;
  std::string antenna_frame_;
  ros::Publisher synced_cloud_, synced_imu_, synced_velocity_, synced_gnss_;
  std::vector<ros::Subscriber> subscribers_;
};

PreprocessingNode::PreprocessingNode(const Config& config, NodeContext& context)
    : config_(config), context_(context), stage_(config.stage, [this](const std::string& frame) {
        return frame.empty() ? std::nullopt : frames_.lookup(config_.node.base_frame, frame);
      }) {
  advertise();
  subscribe_sensors();
  context.worker.set_idle_task(kIdle, [this] { publish(stage_.flush()); });
}

void PreprocessingNode::advertise() {
  ros::NodeHandle& node = context_.node;
  synced_cloud_ = node.advertise<sensor_msgs::PointCloud2>("synced_cloud", kPublisherQueue);
  synced_imu_ = node.advertise<sensor_msgs::Imu>("synced_imu", kPublisherQueue);
  synced_velocity_ =
      node.advertise<geometry_msgs::TwistStamped>("synced_velocity", kPublisherQueue);
  synced_gnss_ = node.advertise<nav_msgs::Odometry>("synced_gnss", kPublisherQueue);
}

void PreprocessingNode::subscribe_sensors() {
  const int scans = config_.node.queue_size;
  const int samples = kSamplesPerScan * scans;
  const auto sample_of = [this](auto add) {
    return [this, add](const auto& message) {
      add(from_message(*message), frame_name(message->header.frame_id));
      publish(stage_.take_complete());
    };
  };
  subscribers_ = {
      subscribe<sensor_msgs::Imu>(
          context_, "imu", samples,
          sample_of([this](const auto& sample, const auto& f) { stage_.add_imu(sample, f); })),
      subscribe<geometry_msgs::TwistStamped>(
          context_, "velocity", samples,
          sample_of([this](const auto& sample, const auto& f) { stage_.add_velocity(sample, f); })),
      subscribe<sensor_msgs::NavSatFix>(context_, "gnss", samples,
                                        sample_of([this](const auto& fix, const auto& f) {
                                          antenna_frame_ = f;
                                          stage_.add_gnss(fix, f);
                                        })),
      subscribe<sensor_msgs::PointCloud2>(context_, "points", scans, [this](const auto& message) {
        context_.diagnostics.count_input(from_ros(message->header.stamp));
        publish(stage_.process(decode(*message, config_.stage).scan));
      })};
}

void PreprocessingNode::publish(const std::vector<preprocessing::SyncedScan>& scans) {
  for (const preprocessing::SyncedScan& scan : scans) publish(scan);
  for (const std::string& notice : stage_.take_notices()) ROS_WARN_STREAM(notice);
  if (!scans.empty()) report();
}

void PreprocessingNode::publish(const preprocessing::SyncedScan& synced) {
  const std::string& base = config_.node.base_frame;
  if (synced.imu) synced_imu_.publish(to_message(*synced.imu, base));
  if (synced.velocity) synced_velocity_.publish(to_message(*synced.velocity, base));
  if (synced.gnss) {
    synced_gnss_.publish(to_message(*synced.gnss, config_.node.map_frame, antenna_frame_));
  }
  synced_cloud_.publish(to_message(synced.scan.cloud, synced.scan.stamp, base));
  context_.diagnostics.count_output(synced.scan.stamp);
}

void PreprocessingNode::report() {
  const preprocessing::PreprocessingCounters& counters = stage_.counters();
  const std::size_t lost = counters.scans_without_extrinsic + counters.scans_without_points +
                           counters.scans_out_of_order;
  context_.diagnostics.set_state(
      lost > 0 ? Diagnostics::Level::kWarning : Diagnostics::Level::kOk,
      lost > 0 ? std::to_string(lost) + " scans dropped" : "synchronising");
  const auto set = [this](const char* key, std::size_t value) {
    context_.diagnostics.set(key, std::to_string(value));
  };
  set("scans in", counters.scans_in);
  set("scans out", counters.scans_out);
  set("scans deskewed here", counters.scans_deskewed);
  set("scans without transform", counters.scans_without_extrinsic);
  set("scans without points", counters.scans_without_points);
  set("scans out of order", counters.scans_out_of_order);
  set("scans completed early", counters.scans_waiting_too_long);
  set("points not finite", counters.points_not_finite);
  set("samples refused", counters.samples_refused);
  set("GNSS fixes refused", counters.gnss_refused);
  set("resets", counters.resets);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::PreprocessingNode>(
      argc, argv, "preprocessing");
}
