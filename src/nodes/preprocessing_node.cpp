// SPDX-License-Identifier: BSD-3-Clause
#include <sstream>
#include <utility>

#include <tf2_msgs/TFMessage.h>
#include <topic_tools/shape_shifter.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/preprocessing/input_validator.hpp"
#include "lidar_mapping/preprocessing/nmea.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/preprocessing/scan_merging.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/node.hpp"
#include "lidar_mapping/ros/node_config.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/transform_odometry.hpp"
#include "lidar_mapping/ros/transforms.hpp"
#include "lidar_mapping/ros/wire_message.hpp"

#include "preprocessing/input_watch.hpp"
#include "preprocessing/ouster_input.hpp"
#include "preprocessing/scan_loss_counter.hpp"

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
/// Duration of the data after which the input validator reports, s. Chosen: enough for rates, units
/// and gaps, and the person who started the nodes is still there.
constexpr double kValidationTime = 5.0;

/// As text with all digits, because a ROS master may round numbers.
std::string to_text(const GeodeticDatum& datum) {
  std::ostringstream text;
  text.precision(17);
  text << datum.latitude_deg << ' ' << datum.longitude_deg << ' ' << datum.altitude_m;
  return text.str();
}

/// Uses the datum of the current run, so that the map's frame stays in place when this node is
/// restarted during a drive.
preprocessing::PreprocessingConfig with_datum_of_the_run(preprocessing::PreprocessingConfig config,
                                                         const ros::NodeHandle& node) {
  std::string text;
  if (config.use_datum || !node.getParam(kRunDatum, text)) return config;
  std::istringstream numbers(text);
  std::vector<double> datum(3);
  if (!(numbers >> datum[0] >> datum[1] >> datum[2])) return config;
  config.use_datum = true;
  config.datum = datum;
  ROS_WARN_STREAM("continuing with the GNSS datum " << text << " of the run before the restart");
  return config;
}

SyncedInputsMessage inputs_of(const preprocessing::SyncedScan& synced) {
  SyncedInputsMessage message;
  message.header.stamp = to_ros(synced.scan.stamp);
  message.imu = synced.imu.has_value();
  message.velocity = synced.velocity.has_value();
  message.gnss = synced.gnss.has_value();
  if (synced.uneven_turning) fill(message, *synced.uneven_turning);
  if (synced.felt) fill(message, *synced.felt);
  return message;
}

/// Of what is left out, the numbers by their reasons. Empty if they are all 0.
std::string left_out(const std::string& what,
                     const std::vector<std::pair<std::size_t, const char*>>& numbers) {
  std::vector<std::string> reasons;
  for (const auto& [count, reason] : numbers) {
    if (count > 0) reasons.push_back(std::to_string(count) + " " + reason);
  }
  return reasons.empty() ? "" : what + ": " + joined(reasons);
}

std::string dropped_scans(const preprocessing::PreprocessingCounters& counters) {
  return left_out("scans dropped", {{counters.scans_without_extrinsic, "without transform"},
                                    {counters.scans_without_points, "without points"},
                                    {counters.scans_out_of_order, "out of order"}});
}

std::string packets_left_out(const OusterLosses& packets) {
  return left_out("packets left out", {{packets.without_metadata, "before the metadata"},
                                       {packets.damaged, "damaged"},
                                       {packets.late, "late"},
                                       {packets.unfinished, "of an unfinished turn"}});
}

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
  void advertise();
  void subscribe_sensors();
  ros::Subscriber subscribe_points();
  void add_cloud(const boost::shared_ptr<const WireMessage>& message);
  void add_cloud(const RecordedCloud& cloud);
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
  void publish(const preprocessing::SyncedScan& scan);
  void publish_datum(Stamp stamp);
  void report();
  std::optional<Pose> T_base(const std::string& frame);
  void validate(const CloudView& message, DecodedCloud& decoded);
  void report_validation();

  Config config_;
  NodeContext& context_;
  SensorFrames frames_;
  CloudReader reader_;
  std::unique_ptr<preprocessing::InputValidator> input_validator_;  ///< until it has reported
  std::optional<Stamp> first_scan_;
  preprocessing::ScanMerger merger_;
  preprocessing::Preprocessor stage_;
  PointCloud spare_cloud_;  ///< memory of a published cloud, reused for the next one
  std::string antenna_frame_;
  std::optional<GeodeticDatum> datum_;  ///< newest published value
  ros::Publisher synced_cloud_, synced_imu_, synced_velocity_, synced_gnss_, synced_inputs_;
  ros::Publisher gnss_datum_;
  ScanLossCounter losses_;
  InputWatch watch_;
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
      input_validator_(std::make_unique<preprocessing::InputValidator>(config.stage)),
      merger_(config.stage.scan_period),
      stage_(with_datum_of_the_run(config.stage, context.node),
             [this](const std::string& frame) { return T_base(frame); }),
      losses_(context),
      watch_(context),
      ouster_(context, watch_, config.node.queue_size, kSamplesPerScan * config.node.queue_size,
              {[this](const RecordedCloud& cloud) {
                 losses_.add(cloud.message.header.seq);
                 add_cloud(cloud);
               },
               [this](const sensor_msgs::Imu& message) { add(input_of(message)); }}) {
  advertise();
  subscribe_sensors();
  context.worker.set_idle_task(kIdle, [this] { flush(); });
}

/// A regular shutdown ends the run, so its datum is removed. After a crash the datum stays, and the
/// restarted node continues the run.
PreprocessingNode::~PreprocessingNode() { context_.node.deleteParam(kRunDatum); }

void PreprocessingNode::advertise() {
  ros::NodeHandle& node = context_.node;
  synced_cloud_ = node.advertise<sensor_msgs::PointCloud2>("synced_cloud", kPublisherQueue);
  synced_imu_ = node.advertise<sensor_msgs::Imu>("synced_imu", kPublisherQueue);
  synced_velocity_ =
      node.advertise<geometry_msgs::TwistStamped>("synced_velocity", kPublisherQueue);
  synced_gnss_ = node.advertise<nav_msgs::Odometry>("synced_gnss", kPublisherQueue);
  synced_inputs_ = node.advertise<SyncedInputsMessage>("synced_inputs", kPublisherQueue);
  gnss_datum_ = node.advertise<sensor_msgs::NavSatFix>("gnss_datum", 1, true);
}

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

/// A cloud of any of cloud_types().
void PreprocessingNode::add_cloud(const boost::shared_ptr<const WireMessage>& message) {
  if (!is_cloud(message->type, message->md5sum)) return warn_of_type(*message, "points");
  add_cloud(whole_cloud(message));
}

/// The report also says why no scan could be published.
void PreprocessingNode::add_cloud(const RecordedCloud& cloud) {
  context_.diagnostics.count_input(from_ros(cloud.message.header.stamp));
  DecodedCloud decoded = reader_.read_lazily(cloud, std::move(spare_cloud_));
  damaged_packets_ += decoded.format.damaged_packets;
  validate(cloud.view(), decoded);
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
  ROS_ERROR_STREAM_ONCE(context_.node.resolveName(topic)
                        << " holds "
                        << (foreign.empty()
                                ? message.type + ", which is not read; "
                                                 "doc/preprocessing.md has the types that are"
                                : foreign + "; " + kForeignRemedy));
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
  if (input_validator_) input_validator_->add_imu(input.sample, input.frame_id);
  stage_.add_imu(input.sample, frame_name(input.frame_id));
  publish(stage_.take_complete());
}

void PreprocessingNode::add(const SensorInput<VelocitySample>& input) {
  watch_.mark_received("velocity");
  if (input_validator_) input_validator_->add_velocity(input.sample, input.frame_id);
  stage_.add_velocity(input.sample, frame_name(input.frame_id));
  publish(stage_.take_complete());
}

void PreprocessingNode::add(const SensorInput<GnssFix>& input) {
  watch_.mark_received("gnss");
  if (input_validator_) input_validator_->add_gnss(input.sample, input.frame_id);
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

void PreprocessingNode::validate(const CloudView& message, DecodedCloud& decoded) {
  watch_.mark_scan();
  if (!input_validator_) return;
  decoded.scan.unpack();
  input_validator_->add_scan(summary_of(message, decoded));
  if (!first_scan_) first_scan_ = decoded.scan.stamp;
  if (to_seconds(decoded.scan.stamp - *first_scan_) < kValidationTime) return;
  report_validation();
  input_validator_.reset();
}

void PreprocessingNode::report_validation() {
  for (const auto& input :
       input_validator_->report([this](const auto& frame) { return T_base(frame); })) {
    ROS_INFO_STREAM(input.input << ": " << input.found);
    context_.diagnostics.set(input.input, input.found);
    for (const preprocessing::CheckDiagnostic& diagnostic : input.diagnostics) {
      ROS_WARN_STREAM(input.input << ": " << sentence(diagnostic));
    }
  }
}

void PreprocessingNode::publish(std::vector<preprocessing::SyncedScan> scans) {
  for (preprocessing::SyncedScan& scan : scans) {
    publish(scan);
    spare_cloud_ = std::move(scan.scan.cloud);
  }
  for (const preprocessing::Diagnostic& diagnostic : stage_.take_diagnostics()) {
    const bool is_info = diagnostic.level == preprocessing::Diagnostic::Level::kInfo;
    ROS_LOG_STREAM(is_info ? ros::console::levels::Info : ros::console::levels::Warn,
                   ROSCONSOLE_DEFAULT_NAME, diagnostic.text);
  }
  if (!scans.empty()) report();
}

void PreprocessingNode::publish(const preprocessing::SyncedScan& synced) {
  const std::string& base = config_.node.base_frame;
  synced_inputs_.publish(inputs_of(synced));
  if (synced.imu) synced_imu_.publish(to_message(*synced.imu, base));
  if (synced.velocity) synced_velocity_.publish(to_message(*synced.velocity, base));
  if (synced.gnss) {
    publish_datum(synced.scan.stamp);
    synced_gnss_.publish(to_message(*synced.gnss, config_.node.map_frame, antenna_frame_));
  }
  synced_cloud_.publish(
      OutgoingCloud(synced.scan.cloud, synced.scan.stamp, frame_name(synced.frame_id)));
  context_.diagnostics.count_output(synced.scan.stamp);
}

/// Publishes the datum when it becomes known and when it changes with a new run.
void PreprocessingNode::publish_datum(Stamp stamp) {
  const std::optional<GeodeticDatum> datum = stage_.datum();
  if (!datum || datum_ == datum) return;
  datum_ = datum;
  sensor_msgs::NavSatFix message;
  message.header = header_of(stamp, config_.node.map_frame);
  message.latitude = datum->latitude_deg;
  message.longitude = datum->longitude_deg;
  message.altitude = datum->altitude_m;
  // The parameter is set before publishing, because subscribers rely on the datum even if this node
  // is killed now.
  context_.node.setParam(kRunDatum, to_text(*datum));
  gnss_datum_.publish(message);
}

void PreprocessingNode::report() {
  losses_.report();
  const preprocessing::PreprocessingCounters& counters = stage_.counters();
  const std::string scans = dropped_scans(counters);
  const std::string packets = packets_left_out(ouster_.losses());
  const std::string lost = scans + (scans.empty() || packets.empty() ? "" : "; ") + packets;
  context_.diagnostics.set_state(
      lost.empty() ? Diagnostics::Level::kOk : Diagnostics::Level::kWarning,
      lost.empty() ? "synchronising" : lost);
  Diagnostics& diagnostics = context_.diagnostics;
  diagnostics.set("scans in", counters.scans_in);
  diagnostics.set("scans out", counters.scans_out);
  diagnostics.set("scans deskewed here", counters.scans_deskewed);
  diagnostics.set("scans without transform", counters.scans_without_extrinsic);
  diagnostics.set("scans without points", counters.scans_without_points);
  diagnostics.set("scans out of order", counters.scans_out_of_order);
  diagnostics.set("scans discarded when time went back", counters.scans_discarded);
  diagnostics.set("scans completed early", counters.scans_waiting_too_long);
  diagnostics.set("points not finite", counters.points_not_finite);
  diagnostics.set("packets damaged", damaged_packets_ + ouster_.losses().damaged);
  diagnostics.set("clouds of other LiDARs left out", other_clouds_left_out_);
  diagnostics.set("samples refused", counters.samples_refused);
  diagnostics.set("GNSS fixes refused", counters.gnss_refused);
  diagnostics.set("resets", counters.resets);
}

}  // namespace lidar_mapping::ros_border

int main(int argc, char** argv) {
  return lidar_mapping::ros_border::run_node<lidar_mapping::ros_border::PreprocessingNode>(
      argc, argv, "preprocessing");
}
