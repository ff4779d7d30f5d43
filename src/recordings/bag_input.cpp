// SPDX-License-Identifier: BSD-3-Clause
#include "bag_input.hpp"

#include <cstdlib>
#include <deque>
#include <iomanip>
#include <limits>
#include <sstream>
#include <utility>

#include <sensor_msgs/Imu.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/preprocessing/scan_merging.hpp"
#include "lidar_mapping/ros/bag_set.hpp"
#include "lidar_mapping/ros/cloud_reader.hpp"
#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/moving_frame.hpp"
#include "lidar_mapping/ros/recorded_cloud.hpp"
#include "lidar_mapping/ros/recorded_frames.hpp"
#include "lidar_mapping/ros/sensor_inputs.hpp"
#include "lidar_mapping/ros/topic_choice.hpp"
#include "lidar_mapping/ros/transform_odometry.hpp"

#include "other_lidars.hpp"

namespace lidar_mapping::recordings {

namespace {

using pipeline::FramedSample;
using pipeline::Input;
using ros_border::BagDamage;
using ros_border::BagMessage;
using ros_border::BagSet;
using ros_border::BagStream;
using ros_border::RecordedCloud;
using ros_border::SensorTopics;

/// Part of the recording whose /tf is read for sensor poses, which are fixed to the vehicle.
constexpr Stamp kFramesTime = from_seconds(20.0);

/// Up to this time a stamp of 0 may be a real one, because simulators start at 0.
constexpr Stamp kSimulatedUntil = from_seconds(1e6);

/// Clocks of stamps and of the recorder that differ by less are taken for one. Chosen: more than
/// any delay on the way to the recorder, less than TAI (37 s) or GPS time (18 s) is ahead of UTC.
constexpr Stamp kSameClock = from_seconds(10.0);

/// The stamp, or the time of recording if the driver sets no stamp.
Stamp given_or_recorded(Stamp stamp, Stamp recorded) {
  return stamp == 0 && recorded > kSimulatedUntil ? recorded : stamp;
}

template <typename Sample>
Input framed(ros_border::SensorInput<Sample> input, Stamp recorded) {
  input.sample.stamp = given_or_recorded(input.sample.stamp, recorded);
  return FramedSample<Sample>{input.sample, ros_border::frame_name(input.frame_id)};
}

std::string frame_of(const RecordedCloud& cloud) {
  return ros_border::frame_name(cloud.message.header.frame_id);
}

/// Why a LiDAR whose first cloud this is cannot be merged with others; empty if it can.
std::string merging_problem(const RecordedCloud& cloud, const ros_border::CloudReader& reader) try {
  return reader.read(cloud).scan.cloud.has_times() ? "" : "their points have no times";
} catch (const InputError& error) {
  return error.what();
}

class RecordedBags : public BagInput {
 public:
  RecordedBags(const std::vector<std::string>& paths, const SensorTopics& wanted,
               const std::string& base_frame, const preprocessing::PreprocessingConfig& config)
      : bags_(paths), config_(config), reader_(config), frames_(base_frame) {
    topics_ = ros_border::topics_in(bags_, wanted);
    read_frames();
    if (const auto cloud = ros_border::first_cloud(bags_, topics_.points)) {
      compare_clocks(*cloud);
      choose_base_frame(frame_of(*cloud));
      take_back_moving_clouds(frame_of(*cloud));
      add_other_lidars(*cloud);
    }
    if (config.enable_robot_odometry_init_guess) {
      topics_.velocity.clear();
      wheels_.emplace(config.robot_odom_frame_id, frames_.base_frame());
    }
    const auto times = bags_.times_of(topics_.by_sensor());
    if (!times) return;
    begin_ = times->first - recorder_ahead_;
    end_ = times->second - recorder_ahead_;
  }

  std::optional<Input> next() override {
    if (!waiting_.empty()) return take_waiting();
    while (const auto message = stream().next()) {
      report_damage();
      if (auto input = readable(*message)) return input;
    }
    if (held_) return merged(std::nullopt);
    if (std::exchange(ended_, true)) return std::nullopt;
    report_missed_clouds();
    report_late_packets();
    if (damaged() == 0) return std::nullopt;
    report_damage();
    messages_.push_back("damaged places of the recording that were left out: " +
                        std::to_string(damaged()));
    return std::nullopt;
  }

  std::vector<std::string> take_messages() override { return std::exchange(messages_, {}); }

  std::vector<preprocessing::InputReport> examine(double seconds) const override {
    return ros_border::check({&bags_, topics_, frames_.base_frame(), seconds}, config_);
  }

  void skip_to(Stamp stamp) override {
    const Stamp recorded = stamp + recorder_ahead_;
    // The clouds of other LiDARs that belong to the first scan were recorded before it.
    stream().skip_to(others_.empty() ? recorded : recorded - from_seconds(2.0 * reach()));
    scans_from_ = recorded;
  }

  Stamp begin() const override { return begin_; }
  Stamp end() const override { return end_; }
  const SensorTopics& topics() const override { return topics_; }
  const std::string& frames_notice() const override { return frames_notice_; }
  std::optional<Pose> T_base(const std::string& frame) const override {
    return frames_.T_base(frame);
  }

 private:
  /// A scan that waits for clouds of other LiDARs.
  struct HeldScan {
    RecordedCloud cloud;
    Stamp stamp = 0;
  };

  std::vector<std::string> wanted_topics() const {
    std::vector<std::string> topics = topics_.by_sensor();
    topics.insert(topics.end(), topics_.other_points.begin(), topics_.other_points.end());
    if (wheels_) topics.emplace_back("/tf");
    return topics;
  }

  BagStream& stream() {
    if (!stream_) stream_.emplace(bags_.messages_of(wanted_topics()));
    return *stream_;
  }

  void read_frames() {
    ros_border::add_recorded_frames(bags_, "/tf_static", std::numeric_limits<Stamp>::min(),
                                    std::numeric_limits<Stamp>::max(), frames_);
    const auto scans = bags_.times_of({topics_.points});
    frames_from_ = scans ? scans->first : 0;
    ros_border::add_recorded_frames(bags_, "/tf", frames_from_, frames_from_ + kFramesTime,
                                    frames_);
  }

  /// A LiDAR may count from its start, or by TAI. Parts of the recording are chosen by stamps.
  void compare_clocks(const RecordedCloud& first) {
    const Stamp stamp = ros_border::from_ros(first.message.header.stamp);
    const auto scans = bags_.times_of({topics_.points});
    if (!scans || given_or_recorded(stamp, scans->first) != stamp) return;
    const Stamp ahead = scans->first - stamp;
    if (std::abs(ahead) > kSameClock) recorder_ahead_ = ahead;
  }

  /// Without a transform to base_link the LiDAR's frame is used as base_link.
  void choose_base_frame(const std::string& lidar_frame) {
    if (frames_.T_base(lidar_frame)) return;
    frames_notice_ = lidar_frame.empty() ? "the scans name no frame"
                                         : "the recording has no transform from '" + lidar_frame +
                                               "' to '" + frames_.base_frame() + "'";
    frames_notice_ +=
        ": the frame of the scans is used as that of the vehicle (x forward, z up), and sensors in "
        "frames without a transform to it are not used";
    if (!lidar_frame.empty()) frames_.set_base_frame(lidar_frame);
  }

  /// Clouds in a frame in which the vehicle moves are taken back to the vehicle by all of /tf.
  void take_back_moving_clouds(const std::string& frame) {
    if (!ros_border::vehicle_moves_in(bags_, frames_.base_frame(), frame)) return;
    // tf2 prints a line for each transform that it has already.
    ros_border::add_recorded_frames(bags_, "/tf", std::numeric_limits<Stamp>::min(),
                                    frames_from_ - 1, frames_);
    ros_border::add_recorded_frames(bags_, "/tf", frames_from_ + kFramesTime + 1,
                                    std::numeric_limits<Stamp>::max(), frames_);
    moving_frame_ = frame;
    frames_notice_ = "the scans are in '" + frame +
                     "', in which the vehicle moves: /tf transforms them back to '" +
                     frames_.base_frame() + "'";
  }

  /// A scan in the moving frame, taken back to where the vehicle was at its stamp.
  void take_back(preprocessing::RawScan& scan) const {
    const auto T_base = frames_.T_base(scan.frame_id, scan.stamp);
    if (!T_base) {
      throw InputError("/tf does not say where the vehicle was in '" + scan.frame_id +
                       "' at a scan of " + std::to_string(to_seconds(scan.stamp)) + " s");
    }
    scan.unpack();
    scan.take_fingerprint();
    scan.cloud = transformed(scan.cloud, *T_base);
    scan.frame_id = frames_.base_frame();
  }

  double reach() const { return preprocessing::merging_reach(config_.scan_period); }

  /// The other LiDARs whose clouds can be merged into the scans. `main` is the first of these.
  void add_other_lidars(const RecordedCloud& main) {
    if (topics_.other_points.empty()) return;
    std::string problem = merging_problem(main, reader_);
    if (!moving_frame_.empty()) problem = "they are in a frame in which the vehicle moves";
    if (!problem.empty()) {
      throw InputError("--points: other LiDARs cannot be merged into the scans of " +
                       topics_.points + ": " + problem + "; name a LiDAR with them first");
    }
    const auto T_base_main = frames_.T_base(frame_of(main));
    for (const std::string& topic : topics_.other_points) add_other_lidar(topic, T_base_main);
  }

  void add_other_lidar(const std::string& topic, const std::optional<Pose>& T_base_main) {
    const auto cloud = ros_border::first_cloud(bags_, topic);
    if (!cloud) return messages_.push_back("no cloud on " + topic + " can be read");
    const std::string frame = frame_of(*cloud);
    const auto T_base_other = frames_.T_base(frame);
    std::string problem = merging_problem(*cloud, reader_);
    if (!T_base_main || !T_base_other) {
      problem = "no transform leads from '" + frame + "' to '" + frames_.base_frame() + "'";
    }
    if (!problem.empty()) {
      return messages_.push_back("the clouds of " + topic + " are left out: " + problem);
    }
    others_.add_lidar(topic, T_base_main->inverse() * *T_base_other);
  }

  /// Holds a scan until the next one has come, and with it the clouds of the other LiDARs.
  std::optional<Input> merged(std::optional<HeldScan> next) {
    const std::optional<HeldScan> held = std::exchange(held_, std::move(next));
    if (!held) return std::nullopt;
    const OtherClouds others = others_.around(held->stamp);
    return pipeline::RecordedScan{
        held->stamp, [held = *held, others, this](PointCloud buffer) {
          preprocessing::RawScan scan = decoded(held.cloud, held.stamp, std::move(buffer));
          for (const auto& other : others) {
            preprocessing::append_points(scan, other->decoded(reader_), other->T_main_other(),
                                         preprocessing::PassLimits(config_));
          }
          return scan;
        }};
  }

  void report_missed_clouds() {
    for (const auto& [topic, scans] : others_.missed()) {
      messages_.push_back(std::to_string(scans) + " scans have no points of " + topic +
                          ": it has no clouds at their time");
    }
  }

  void report_late_packets() {
    const std::size_t late = stream_->late_packets();
    if (late == 0) return;
    messages_.push_back("packets of the sensor that came behind their turn and were left out: " +
                        std::to_string(late));
  }

  preprocessing::RawScan decoded(const RecordedCloud& cloud, Stamp stamp, PointCloud buffer) const {
    preprocessing::RawScan scan = reader_.read_lazily(cloud, std::move(buffer)).scan;
    scan.stamp = stamp;
    if (scan.frame_id.empty()) scan.frame_id = frames_.base_frame();
    if (scan.frame_id == moving_frame_) take_back(scan);
    return scan;
  }

  std::size_t damaged() const { return stream_->damage().places + damaged_messages_; }

  /// Reports the first damage; the total is reported at the end.
  void report_damage() {
    const BagDamage& damage = stream_->damage();
    if (damage.places == 0 || std::exchange(damage_reported_, true)) return;
    std::ostringstream text;
    text << std::fixed << std::setprecision(3) << damage.reason << "; what was recorded at "
         << to_seconds(damage.first) << " s is left out";
    messages_.push_back(text.str());
  }

  std::optional<Input> take_waiting() {
    std::optional<Input> input(std::move(waiting_.front()));
    waiting_.pop_front();
    return input;
  }

  /// A message of /tf may hold several poses.
  std::optional<Input> read_wheels(const tf2_msgs::TFMessage& message) {
    for (const VelocitySample& sample : wheels_->add(message)) {
      waiting_.push_back(FramedSample<VelocitySample>{sample, frames_.base_frame()});
    }
    return waiting_.empty() ? std::nullopt : take_waiting();
  }

  std::optional<Input> readable(const BagMessage& message) try {
    if (wheels_) {
      if (const auto frames = ros_border::read_transforms(message)) return read_wheels(*frames);
    }
    return read(message);
  } catch (const ros::Exception&) {
    ++damaged_messages_;
    return std::nullopt;
  }

  std::optional<Input> read(const BagMessage& message) {
    if (const auto cloud = ros_border::read_cloud(message)) {
      const Stamp stamp =
          given_or_recorded(ros_border::from_ros(cloud->message.header.stamp), message.recorded);
      if (others_.has(message.topic())) {
        others_.add(message.topic(), *cloud, stamp);
        return std::nullopt;
      }
      if (message.topic() != topics_.points || message.recorded < scans_from_) return std::nullopt;
      if (!others_.empty()) return merged(HeldScan{*cloud, stamp});
      return pipeline::RecordedScan{stamp, [cloud = *cloud, stamp, this](PointCloud buffer) {
                                      return decoded(cloud, stamp, std::move(buffer));
                                    }};
    }
    if (const auto imu = message.instantiate<sensor_msgs::Imu>()) {
      return framed(ros_border::input_of(*imu), message.recorded);
    }
    if (const auto velocity = ros_border::VelocityMessages::read(message)) {
      return framed(*velocity, message.recorded);
    }
    if (const auto fix = ros_border::GnssMessages::read(message)) {
      return framed(*fix, message.recorded);
    }
    return std::nullopt;
  }

  BagSet bags_;
  preprocessing::PreprocessingConfig config_;
  ros_border::CloudReader reader_;
  SensorTopics topics_;
  ros_border::RecordedFrames frames_;
  Stamp frames_from_ = 0;     ///< begin of the part whose /tf was read first
  std::string moving_frame_;  ///< of scans that are taken back; empty if there are none
  std::string frames_notice_;
  OtherLidars others_{reach()};
  std::optional<HeldScan> held_;
  Stamp scans_from_ =
      std::numeric_limits<Stamp>::min();                 ///< when the first wanted one was recorded
  std::optional<ros_border::TransformOdometry> wheels_;  ///< set if the velocity is read from tf
  std::deque<Input> waiting_;                            ///< further samples of the last message
  Stamp recorder_ahead_ = 0;  ///< of the stamps' clock, ns; 0 if it is the same
  Stamp begin_ = 0;           ///< by the stamps' clock, as end_
  Stamp end_ = 0;
  std::optional<BagStream> stream_;
  std::size_t damaged_messages_ =
      0;  ///< undamaged in the bag, but not of the structure of their type
  bool damage_reported_ = false;
  bool ended_ = false;
  std::vector<std::string> messages_;
};

}  // namespace

std::unique_ptr<BagInput> make_bag_input(const std::vector<std::string>& paths,
                                         const SensorTopics& wanted, const std::string& base_frame,
                                         const preprocessing::PreprocessingConfig& config) {
  return std::make_unique<RecordedBags>(paths, wanted, base_frame, config);
}

}  // namespace lidar_mapping::recordings
