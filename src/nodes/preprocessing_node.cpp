// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <tf2_msgs/TFMessage.h>
#include <topic_tools/shape_shifter.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/preprocessing/nmea.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/preprocessing/scan_merging.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/transform_odometry.hpp"
#include "lidar_mapping/ros/transforms.hpp"
#include "lidar_mapping/ros/warning_limiter.hpp"
#include "lidar_mapping/ros/wire_message.hpp"

#include "preprocessing/input_check.hpp"
#include "preprocessing/input_watch.hpp"
#include "preprocessing/ouster_input.hpp"
#include "preprocessing/preprocessing_figures.hpp"
#include "preprocessing/run_datum.hpp"
#include "preprocessing/scan_loss_counter.hpp"
#include "preprocessing/synced_publisher.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Idle time after which scans that wait for other sensors are published without them.
constexpr std::chrono::milliseconds kIdle{1000};
/// Queue length of the other sensors for each queued scan. Chosen: IMUs publish ten to twenty times
/// as often as LiDARs.
constexpr int kSamplesPerScan = 20;
/// Length of roscpp's queue for the points. Chosen: a second of the packets of an Ouster, which is
/// longer than any burst of them.
constexpr std::uint32_t kPointsTransportQueue = 1280;

/// Keeps the message as long as the cloud. Throws InputError if it is shorter than it says.
RecordedCloud whole_cloud(const boost::shared_ptr<const WireMessage>& message) try {
  return read_cloud(message->type, message->md5sum, message->bytes(),
                    {message.get(), [message](const void*) {}});
} catch (const ros::Exception&) {
  throw InputError("a message of " + message->type + " with " +
                   std::to_string(message->data.size()) + " bytes is cut off and left out");
}

}  // namespace

/// Subscribed: points, other_points, imu, velocity, gnss, tf, and beside packets of an Ouster
/// metadata and imu_packets. Published: synced_cloud, synced_imu, synced_velocity, synced_gnss,
/// synced_inputs, all with the stamp of their scan; gnss_datum, scans_lost (both latched).
class PreprocessingNode {
 public:
  using Config = NodeConfig<preprocessing::PreprocessingConfig>;

  PreprocessingNode(const Config& config, NodeContext& context);
  ~PreprocessingNode();

 private:
  void subscribe_sensors();
  ros::Subscriber subscribe_points();
  void add_cloud(const boost::shared_ptr<const WireMessage>& message);
  void add_cloud(const RecordedCloud& cloud);
  void explain(const std::string& problem);
  template <typename Read>
  auto explained(const Read& read);
  void add_other_cloud(const boost::shared_ptr<const WireMessage>& message);
  void process(preprocessing::RawScan scan);
  void flush();
  void warn_of_type(const WireMessage& message, const std::string& topic);
  void add_imu(const WireMessage& message);
  void add(const SensorInput<ImuSample>& input);
  void add(const SensorInput<VelocitySample>& input);
  void add(const SensorInput<GnssFix>& input);
  void follow_transforms();
  void check_sentence(const topic_tools::ShapeShifter& message);
  template <typename Messages>
  void add_if_readable(const std::string& topic, const topic_tools::ShapeShifter& message);
  void publish(std::vector<preprocessing::SyncedScan> scans);
  void report();
  std::optional<Pose> T_base(const std::string& frame);

  Config config_;
  NodeContext& context_;
  SensorFrames frames_;
  CloudReader reader_;
  InputCheck input_check_;
  preprocessing::ScanMerger merger_;
  preprocessing::Preprocessor stage_;
  PointCloud spare_cloud_;  ///< memory of a published cloud, reused for the next one
  std::string antenna_frame_;
  SyncedPublisher publisher_;
  ScanLossCounter losses_;
  InputWatch watch_;
  WarningLimiter limiter_;
  preprocessing::SentenceCheck sentences_;
  std::size_t damaged_packets_ = 0;        ///< left out of the clouds that are made of packets
  std::size_t other_clouds_left_out_ = 0;  ///< of other LiDARs, without times or transform
  OusterInput ouster_;
  std::vector<ros::Subscriber> subscribers_;
};

PreprocessingNode::PreprocessingNode(const Config& config, NodeContext& context)
    : config_(config),
      context_(context),
      reader_(config.stage),
      input_check_(context, config.stage,
                   [this](const std::string& frame) { return T_base(frame); }),
      merger_(config.stage),
      stage_(with_datum_of_the_run(config.stage, context.node),
             [this](const std::string& frame) { return T_base(frame); }),
      publisher_(context, config.node),
      losses_(context),
      watch_(context),
      ouster_(context, watch_, config.node.queue_size, kSamplesPerScan * config.node.queue_size,
              {[this](const RecordedCloud& cloud) {
                 losses_.add(cloud.message.header.seq);
                 add_cloud(cloud);
               },
               [this](const sensor_msgs::Imu& message) { add(input_of(message)); }}) {
  subscribe_sensors();
  context.worker.set_idle_task(kIdle, [this] { flush(); });
}

/// A regular shutdown ends the run, so its datum is removed. After a crash the datum stays, and the
/// restarted node continues the run.
PreprocessingNode::~PreprocessingNode() { end_datum_of_the_run(context_.node); }

void PreprocessingNode::subscribe_sensors() {
  const int scans = config_.node.queue_size;
  const int samples = kSamplesPerScan * scans;
  subscribers_ = {
      subscribe<WireMessage>(context_, "imu", samples,
                             [this](const auto& message) { add_imu(*message); }),
      subscribe<topic_tools::ShapeShifter>(context_, "gnss", samples,
                                           [this](const auto& message) {
                                             check_sentence(*message);
                                             add_if_readable<GnssMessages>("gnss", *message);
                                           }),
      subscribe_points(),
      subscribe<WireMessage>(context_, "other_points", scans,
                             [this](const auto& message) { add_other_cloud(message); })};
  if (config_.stage.enable_robot_odometry_init_guess) return follow_transforms();
  subscribers_.push_back(subscribe<topic_tools::ShapeShifter>(
      context_, "velocity", samples,
      [this](const auto& message) { add_if_readable<VelocityMessages>("velocity", *message); }));
}

/// Packets of which many make a scan wait in a queue of their own.
ros::Subscriber PreprocessingNode::subscribe_points() {
  const auto channel =
      context_.worker.add_channel("points", static_cast<std::size_t>(config_.node.queue_size));
  return subscribe_arrivals<WireMessage>(
      context_, "points", kPointsTransportQueue,
      [this, channel](const ros::MessageEvent<const WireMessage>& event) {
        const boost::shared_ptr<const WireMessage> message = event.getConstMessage();
        if (is_ouster_packet(message->type, message->md5sum)) return ouster_.post(message);
        losses_.add(message->sequence());
        context_.worker.post(channel, [this, message] { add_cloud(message); });
      });
}

/// Uses the velocity of a wheel odometry that is published as transforms.
void PreprocessingNode::follow_transforms() {
  if (config_.stage.robot_odom_frame_id == config_.node.odom_frame) {
    throw ConfigError("robot_odom_frame_id: '" + config_.node.odom_frame +
                      "' is the frame of this package's own odometry (odom_frame); give one of the "
                      "two another name");
  }
  auto odometry = std::make_shared<TransformOdometry>(config_.stage.robot_odom_frame_id,
                                                      config_.node.base_frame);
  subscribers_.push_back(subscribe<tf2_msgs::TFMessage>(
      context_, "/tf", kSamplesPerScan * config_.node.queue_size,
      [this, odometry](const auto& message) {
        for (const VelocitySample& sample : odometry->add(*message)) {
          add(SensorInput<VelocitySample>{sample, config_.node.base_frame});
        }
      }));
}

/// Scans that cannot be read have arrived: that they had not was said otherwise.
void PreprocessingNode::explain(const std::string& problem) {
  if (!limiter_.due("points")) return;
  watch_.explain(context_.node.resolveName("points") + ": " + problem);
}

/// What `read` returns; the error that it throws is also why there are no scans yet.
template <typename Read>
auto PreprocessingNode::explained(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    explain(error.what());
    throw;
  }
}

/// A cloud of any of cloud_types().
void PreprocessingNode::add_cloud(const boost::shared_ptr<const WireMessage>& message) {
  if (!is_cloud(message->type, message->md5sum)) return warn_of_type(*message, "points");
  add_cloud(explained([&] { return whole_cloud(message); }));
}

/// The report also says why no scan could be published.
void PreprocessingNode::add_cloud(const RecordedCloud& cloud) {
  context_.diagnostics.count_input(from_ros(cloud.message.header.stamp));
  DecodedCloud decoded =
      explained([&] { return reader_.read_lazily(cloud, std::move(spare_cloud_)); });
  damaged_packets_ += decoded.format.damaged_packets;
  watch_.mark_scan();
  input_check_.add_scan(cloud.view(), decoded);
  process(std::move(decoded.scan));
  report();
}

/// A cloud of another LiDAR than that of the topic points; several may use the topic, each with a
/// frame of its own.
void PreprocessingNode::add_other_cloud(const boost::shared_ptr<const WireMessage>& message) {
  if (!is_cloud(message->type, message->md5sum)) return warn_of_type(*message, "other_points");
  DecodedCloud decoded = reader_.read(whole_cloud(message));
  damaged_packets_ += decoded.format.damaged_packets;
  preprocessing::RawScan scan = std::move(decoded.scan);
  const std::optional<Pose> T_base_other = T_base(scan.frame_id);
  if (T_base_other && scan.cloud.has_times()) {
    return merger_.add_other(std::move(scan), *T_base_other);
  }
  ++other_clouds_left_out_;
  constexpr double kPause = 10.0;  // s; chosen: once in a hundred clouds
  ROS_WARN_STREAM_THROTTLE(
      kPause, "the clouds of '" << scan.frame_id << "' on "
                                << context_.node.resolveName("other_points") << " are left out: "
                                << (T_base_other ? "their points have no times"
                                                 : "no transform leads to them from the vehicle"));
}

/// Hands a scan on, with the points of other LiDARs if there are any.
void PreprocessingNode::process(preprocessing::RawScan scan) {
  const std::optional<Pose> T_base_lidar =
      merger_.has_others() ? T_base(scan.frame_id) : std::nullopt;
  if (!T_base_lidar) return publish(stage_.process(std::move(scan)));
  std::vector<preprocessing::RawScan> complete = merger_.add(std::move(scan), *T_base_lidar);
  for (preprocessing::RawScan& each : complete) publish(stage_.process(std::move(each)));
}

/// Nothing has come for a while: nothing is waited for any more.
void PreprocessingNode::flush() {
  ouster_.finish();
  if (auto scan = merger_.flush()) publish(stage_.process(std::move(*scan)));
  publish(stage_.flush());
  report();
}

void PreprocessingNode::warn_of_type(const WireMessage& message, const std::string& topic) {
  const std::string foreign = foreign_definition(message.type, message.md5sum);
  const std::string problem =
      "holds " + (foreign.empty() ? message.type +
                                        ", which is not read; doc/preprocessing.md has the types "
                                        "that are"
                                  : foreign + "; " + kForeignRemedy);
  ROS_ERROR_STREAM_ONCE(context_.node.resolveName(topic) << " " << problem);
  if (topic == "points") explain(problem);
}

/// A sample, also as a packet of an Ouster.
void PreprocessingNode::add_imu(const WireMessage& message) {
  const bool is_packet = is_ouster_packet(message.type, message.md5sum);
  if (!is_packet && !message.is<sensor_msgs::Imu>()) {
    ROS_ERROR_STREAM_ONCE(context_.node.resolveName("imu")
                          << " holds " << message.type
                          << ", which is not read; doc/preprocessing.md has the types that are");
    return;
  }
  ouster_.mark_other_imu();
  add(input_of(is_packet ? ouster_.imu_in(message) : message.instantiate<sensor_msgs::Imu>()));
}

void PreprocessingNode::add(const SensorInput<ImuSample>& input) {
  watch_.mark_received("imu");
  input_check_.add(input);
  stage_.add_imu(input.sample, frame_name(input.frame_id));
  publish(stage_.take_complete());
}

void PreprocessingNode::add(const SensorInput<VelocitySample>& input) {
  watch_.mark_received("velocity");
  input_check_.add(input);
  stage_.add_velocity(input.sample, frame_name(input.frame_id));
  publish(stage_.take_complete());
}

void PreprocessingNode::add(const SensorInput<GnssFix>& input) {
  watch_.mark_received("gnss");
  input_check_.add(input);
  antenna_frame_ = frame_name(input.frame_id);
  stage_.add_gnss(input.sample, antenna_frame_);
  publish(stage_.take_complete());
}

void PreprocessingNode::check_sentence(const topic_tools::ShapeShifter& message) {
  if (message.getDataType() != ros::message_traits::DataType<NmeaSentence>::value()) return;
  const std::string warning = sentences_.add(message.instantiate<NmeaSentence>()->sentence);
  if (!warning.empty()) ROS_WARN_STREAM(context_.node.resolveName("gnss") << ": " << warning);
}

template <typename Messages>
void PreprocessingNode::add_if_readable(const std::string& topic,
                                        const topic_tools::ShapeShifter& message) {
  if (const auto input = Messages::read(message)) return add(*input);
  if (contains(Messages::types(), message.getDataType())) return;
  ROS_ERROR_STREAM_ONCE(context_.node.resolveName(topic)
                        << " holds " << message.getDataType()
                        << ", which is not read; doc/preprocessing.md has the types that are");
}

std::optional<Pose> PreprocessingNode::T_base(const std::string& frame) {
  if (frame.empty()) return std::nullopt;
  return frames_.lookup(config_.node.base_frame, frame);
}

void PreprocessingNode::publish(std::vector<preprocessing::SyncedScan> scans) {
  for (preprocessing::SyncedScan& scan : scans) {
    publisher_.publish(scan, antenna_frame_, stage_.datum());
    context_.diagnostics.count_output(scan.scan.stamp);
    spare_cloud_ = std::move(scan.scan.cloud);
  }
  for (const preprocessing::Diagnostic& diagnostic : stage_.take_diagnostics()) {
    const bool is_info = diagnostic.level == preprocessing::Diagnostic::Level::kInfo;
    ROS_LOG_STREAM(is_info ? ros::console::levels::Info : ros::console::levels::Warn,
                   ROSCONSOLE_DEFAULT_NAME, diagnostic.text);
  }
  if (!scans.empty()) report();
}

void PreprocessingNode::report() {
  losses_.report();
  show({stage_.counters(), ouster_.losses(), damaged_packets_, other_clouds_left_out_},
       context_.diagnostics);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::PreprocessingNode>(argc,
                                                                                           argv);
}
