// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/synced_publisher.hpp"

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>

#include "lidar_mapping/ros/geometry_conversions.hpp"
#include "lidar_mapping/ros/messages.hpp"
#include "lidar_mapping/ros/outgoing_cloud.hpp"
#include "lidar_mapping/ros/sensor_conversions.hpp"

#include "preprocessing/run_datum.hpp"

namespace lidar_mapping::ros_border {

namespace {

SyncedInputsMessage inputs_of(const preprocessing::SyncedScan& synced) {
  SyncedInputsMessage message;
  message.header.stamp = to_ros(synced.scan.stamp);
  message.imu = synced.imu.has_value();
  message.velocity = synced.velocity.has_value();
  message.gnss = synced.gnss.has_value();
  if (synced.uneven_turning) fill(message, *synced.uneven_turning);
  if (synced.felt) fill(message, *synced.felt);
  message.fingerprint = synced.fingerprint.value_or(0);
  return message;
}

}  // namespace

SyncedPublisher::SyncedPublisher(NodeContext& context, const NodeFields& frames)
    : context_(context), frames_(frames) {
  ros::NodeHandle& node = context_.node;
  cloud_ = node.advertise<sensor_msgs::PointCloud2>("synced_cloud", kPublisherQueue);
  imu_ = node.advertise<sensor_msgs::Imu>("synced_imu", kPublisherQueue);
  velocity_ = node.advertise<geometry_msgs::TwistStamped>("synced_velocity", kPublisherQueue);
  gnss_ = node.advertise<nav_msgs::Odometry>("synced_gnss", kPublisherQueue);
  inputs_ = node.advertise<SyncedInputsMessage>("synced_inputs", kPublisherQueue);
  gnss_datum_ = node.advertise<sensor_msgs::NavSatFix>("gnss_datum", 1, true);
}

void SyncedPublisher::publish(const preprocessing::SyncedScan& synced,
                              const std::string& antenna_frame,
                              const std::optional<GeodeticDatum>& datum) {
  inputs_.publish(inputs_of(synced));
  if (synced.imu) imu_.publish(to_message(*synced.imu, frames_.base_frame));
  if (synced.velocity) velocity_.publish(to_message(*synced.velocity, frames_.base_frame));
  if (synced.gnss) {
    publish_datum(synced.scan.stamp, datum);
    gnss_.publish(to_message(*synced.gnss, frames_.map_frame, antenna_frame));
  }
  cloud_.publish(OutgoingCloud(synced.scan.cloud, synced.scan.stamp, frame_name(synced.frame_id)));
}

/// Publishes the datum when it becomes known and when it changes with a new run.
void SyncedPublisher::publish_datum(Stamp stamp, const std::optional<GeodeticDatum>& datum) {
  if (!datum || datum_ == datum) return;
  datum_ = datum;
  sensor_msgs::NavSatFix message;
  message.header = header_of(stamp, frames_.map_frame);
  message.latitude = datum->latitude_deg;
  message.longitude = datum->longitude_deg;
  message.altitude = datum->altitude_m;
  // The parameter is set before publishing, because subscribers rely on the datum even if this node
  // is killed now.
  store_datum_of_the_run(*datum, context_.node);
  gnss_datum_.publish(message);
}

}  // namespace lidar_mapping::ros_border
