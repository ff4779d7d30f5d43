// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/recording_check.hpp"

#include <limits>
#include <map>
#include <optional>
#include <set>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/preprocessing/input_validator.hpp"
#include "lidar_mapping/preprocessing/nmea.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/cloud_types.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/moving_frame.hpp"
#include "lidar_mapping/ros/ouster_messages.hpp"
#include "lidar_mapping/ros/point_cloud_decoder.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"
#include "lidar_mapping/ros/recorded_frames.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"

namespace lidar_mapping::ros_border {

namespace {

using preprocessing::CheckDiagnostic;
using preprocessing::InputReport;
using preprocessing::Severity;

/// Types of messages with raw data of a LiDAR instead of a cloud, and how to convert them.
const std::map<std::string, std::string> kRawScans = {
    {kOusterPacket,
     "record the driver's topic metadata beside them, or convert them with ouster_ros's "
     "replay.launch"},
    {"hesai_ros_driver/UdpFrame", "convert them with hesai_ros_driver (source_type 3)"},
    {"rslidar_msgs/rslidarScan", "convert them with rslidar_sdk (msg_source 2)"}};

const CheckDiagnostic kNoClouds = {Severity::kFault,
                                   "no topic of the recording holds clouds of points",
                                   "record the clouds that the LiDAR's driver publishes"};

/// Types of messages with raw data of a GNSS receiver instead of a fix, and the remedy.
const std::map<std::string, std::string> kRawFixes = {
    {"ublox_msgs/NavPVT", "convert them with ublox_gps, which publishes sensor_msgs/NavSatFix"},
    {"novatel_gps_msgs/NovatelPosition", "record novatel_gps_driver's fix beside them"}};

/// The remedy for a recording that has only raw data of the sensor.
std::optional<CheckDiagnostic> raw_data_in(const BagSet& bags,
                                           const std::map<std::string, std::string>& known,
                                           Severity severity, const std::string& wanted) {
  for (const BagTopic& topic : bags.topics()) {
    const auto found = known.find(topic.type);
    if (found == known.end()) continue;
    return CheckDiagnostic{severity, topic.name + " holds " + topic.type + ", not " + wanted,
                           found->second};
  }
  return std::nullopt;
}

/// The first topic whose messages have the name of a type that is read, and another definition.
std::optional<CheckDiagnostic> foreign_definitions_in(const BagSet& bags) {
  for (const BagTopic& topic : bags.topics()) {
    const std::string problem = foreign_definition(topic.type, topic.md5sum);
    if (problem.empty()) continue;
    return CheckDiagnostic{Severity::kFault, topic.name + " holds " + problem, kForeignRemedy};
  }
  return std::nullopt;
}

/// The first topic with clouds none of which can be read.
std::optional<CheckDiagnostic> unreadable_clouds_in(const BagSet& bags) {
  for (const BagTopic& topic : bags.topics()) {
    if (!is_cloud(topic.type, topic.md5sum) || topic.messages == 0) continue;
    BagStream messages = bags.messages_of({topic.name});
    messages.next();
    const std::string reason = messages.damage().reason;
    return CheckDiagnostic{Severity::kFault,
                           "no message on " + topic.name + " (" + topic.type +
                               ") can be read: " + (reason.empty() ? "they are cut off" : reason),
                           "copy the recording again, or record it anew"};
  }
  return std::nullopt;
}

/// Why there are no clouds at all.
CheckDiagnostic why_no_clouds(const BagSet& bags) {
  if (const auto foreign = foreign_definitions_in(bags)) return *foreign;
  if (const auto unreadable = unreadable_clouds_in(bags)) return *unreadable;
  const auto raw = raw_data_in(bags, kRawScans, Severity::kFault, "a cloud");
  return raw ? *raw : kNoClouds;
}

/// "; other clouds: /a, /b" or nothing.
std::string other_clouds(const RecordingCheck& recording) {
  std::vector<std::string> names;
  for (const std::string& topic : cloud_topics(*recording.bags)) {
    if (topic != recording.topics.points) names.push_back(topic);
  }
  return names.empty() ? "" : "; other clouds: " + joined(names);
}

/// Types of messages of sensors whose measurements are not used, and why.
const std::map<std::string, std::string> kOtherSensors = {
    {"sensor_msgs/LaserScan", "a single plane"},
    {"sensor_msgs/MultiEchoLaserScan", "a single plane"},
    {"sensor_msgs/Range", "a single distance"},
    {"radar_msgs/RadarScan", "a radar"}};

/// "; not used: /scan (sensor_msgs/LaserScan: a single plane)" or nothing.
std::string unused_topics(const BagSet& bags) {
  std::vector<std::string> names;
  for (const BagTopic& topic : bags.topics()) {
    const auto known = kOtherSensors.find(topic.type);
    if (known == kOtherSensors.end()) continue;
    names.push_back(topic.name + " (" + topic.type + ": " + known->second + ")");
  }
  return names.empty() ? "" : "; not used: " + joined(names);
}

/// "; tf has 'odom' as the parent of 'base_link': ..." or nothing. The front end is that parent
/// while the nodes run, and a frame has one only.
std::string note_on_parents(const std::set<std::string>& parents, const std::string& base_frame) {
  if (parents.empty()) return "";
  const std::vector<std::string> names(parents.begin(), parents.end());
  return "; tf has '" + joined(names) + "' as the parent of '" + base_frame +
         "': for the nodes, play it with /tf:=/tf_recorded, or name the uppermost frame of the "
         "vehicle by base_frame";
}

/// What is wrong with clouds in a frame in which the vehicle moves; empty if it does not.
std::optional<CheckDiagnostic> moving_clouds_in(const RecordingCheck& recording) {
  const auto cloud = first_cloud(*recording.bags, recording.topics.points);
  if (!cloud) return std::nullopt;
  const std::string frame = frame_name(cloud->message.header.frame_id);
  if (!vehicle_moves_in(*recording.bags, recording.base_frame, frame)) return std::nullopt;
  return CheckDiagnostic{
      Severity::kWarning,
      "the clouds are in '" + frame + "', a frame in which '" + recording.base_frame + "' moves",
      "map_bag transforms them back by /tf, whose errors are then in the points; record the clouds "
      "of the driver"};
}

/// End of the checked part.
Stamp end_of(const RecordingCheck& recording) {
  constexpr Stamp kForever = std::numeric_limits<Stamp>::max();
  if (recording.seconds <= 0.0) return kForever;
  const auto times = recording.bags->times_of({recording.topics.points});
  return times ? times->first + from_seconds(recording.seconds) : kForever;
}

class RecordingValidator {
 public:
  /// `clouds_move`: the vehicle moves in the frame of the clouds.
  RecordingValidator(const RecordingCheck& recording,
                     const preprocessing::PreprocessingConfig& config, bool clouds_move)
      : reader_(config),
        input_validator_(config),
        frames_(recording.base_frame),
        base_frame_(recording.base_frame),
        clouds_move_(clouds_move) {
    // Also what stands behind the checked part holds for all of the recording.
    add_recorded_frames(*recording.bags, "/tf_static", std::numeric_limits<Stamp>::min(),
                        std::numeric_limits<Stamp>::max(), frames_);
  }

  void add(const BagMessage& message) try {
    if (const auto cloud = read_cloud(message)) {
      add(*cloud, message);
    } else if (const auto imu = message.instantiate<sensor_msgs::Imu>()) {
      const ImuSample sample = from_message(*imu);
      input_validator_.add_imu(sample, imu->header.frame_id, delay(message, sample.stamp));
    } else if (const auto velocity = VelocityMessages::read(message)) {
      input_validator_.add_velocity(velocity->sample, velocity->frame_id,
                                    delay(message, velocity->sample.stamp));
    } else if (const auto fix = GnssMessages::read(message)) {
      input_validator_.add_gnss(fix->sample, fix->frame_id, delay(message, fix->sample.stamp));
    } else if (const auto sentence = message.instantiate<NmeaSentence>()) {
      const std::string warning = sentences_.add(sentence->sentence);
      if (!warning.empty()) no_gga_ = warning;
    } else if (const auto frames = read_transforms(message)) {
      frames_.add(*frames, message.topic() == "/tf_static");
      for (const geometry_msgs::TransformStamped& transform : frames->transforms) {
        if (frame_name(transform.child_frame_id) != base_frame_) continue;
        parents_.insert(frame_name(transform.header.frame_id));
      }
    }
  } catch (const ros::Exception& error) {
    if (damaged_++ == 0) damage_ = "a message on " + message.topic() + ": " + error.what();
  }

  /// Adds damage of the bags themselves.
  void add(const BagDamage& damage) {
    if (damage.places > 0) damage_ = damage.reason;
    damaged_ += damage.places;
  }
  /// Frames of which the vehicle's is a child.
  const std::set<std::string>& parents() const { return parents_; }
  /// Adds packets of an Ouster that came when their turn had been given out.
  void add_late_packets(std::size_t count) { late_packets_ += count; }

  std::vector<InputReport> reports() const {
    auto reports =
        input_validator_.report([this](const auto& frame) { return frames_.T_base(frame); });
    if (!no_gga_.empty()) {
      reports.back().diagnostics.push_back(
          {Severity::kWarning, no_gga_, "without GGA there is no GNSS"});
    }
    if (!frames_.problem().empty()) {
      reports.front().diagnostics.push_back(
          {Severity::kFault, frames_.problem(),
           "it is left out; correct its publisher (no rotation is 0 0 0 1)"});
    }
    if (unreadable_ > 0) {
      reports.front().diagnostics.push_back(
          {Severity::kFault,
           std::to_string(unreadable_) + " clouds cannot be read, first " + problem_,
           "they are dropped"});
    }
    if (late_packets_ > 0) {
      reports.front().diagnostics.push_back(
          {Severity::kWarning,
           std::to_string(late_packets_) + " packets of the sensor came behind their turn",
           "they are left out; look at the network between sensor and computer"});
    }
    if (damaged_ > 0) {
      reports.front().diagnostics.push_back(
          {Severity::kFault,
           std::to_string(damaged_) + " places of the recording are damaged, among them " + damage_,
           "copy it again; what is damaged is left out"});
    }
    return reports;
  }

 private:
  /// s from the stamp to the delivery.
  static double delay(const BagMessage& message, Stamp stamp) {
    return to_seconds(message.recorded - stamp);
  }

  void add(const RecordedCloud& cloud, const BagMessage& message) try {
    preprocessing::CloudSummary summary = summary_of(cloud.view(), reader_.read(cloud));
    summary.delay = delay(message, summary.stamp);
    if (clouds_move_) summary.extent.reset();
    input_validator_.add_scan(summary);
  } catch (const InputError& error) {
    if (unreadable_++ == 0) problem_ = error.what();
  }

  CloudReader reader_;
  preprocessing::InputValidator input_validator_;
  RecordedFrames frames_;
  std::string base_frame_;
  std::set<std::string> parents_;
  bool clouds_move_;
  std::size_t unreadable_ = 0;
  std::string problem_;  ///< reason of the first of them
  preprocessing::SentenceCheck sentences_;
  std::string no_gga_;  ///< what is wrong with the sentences of the receiver
  std::size_t late_packets_ = 0;
  std::size_t damaged_ = 0;
  std::string damage_;  ///< reason of one of them
};

}  // namespace

std::vector<InputReport> check(const RecordingCheck& recording,
                               const preprocessing::PreprocessingConfig& config) {
  const SensorTopics& t = recording.topics;
  const Stamp end = end_of(recording);
  BagStream messages =
      recording.bags->messages_of({t.points, t.imu, t.velocity, t.gnss, "/tf", "/tf_static"});
  const auto moving = moving_clouds_in(recording);
  RecordingValidator validator(recording, config, moving.has_value());
  for (auto message = messages.next(); message && message->recorded <= end;
       message = messages.next()) {
    validator.add(*message);
  }
  validator.add(messages.damage());
  validator.add_late_packets(messages.late_packets());
  std::vector<InputReport> reports = validator.reports();
  reports.front().found += other_clouds(recording) + unused_topics(*recording.bags) +
                           note_on_parents(validator.parents(), recording.base_frame);
  if (moving) reports.front().diagnostics.push_back(*moving);
  if (t.points.empty()) reports.front().diagnostics = {why_no_clouds(*recording.bags)};
  if (t.gnss.empty()) {
    const auto raw = raw_data_in(*recording.bags, kRawFixes, Severity::kWarning, "NavSatFix");
    if (raw) reports.back().diagnostics.push_back(*raw);
  }
  return reports;
}

}  // namespace lidar_mapping::ros_border
