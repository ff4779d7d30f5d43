// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <sqlite3.h>
#include <tf2_msgs/TFMessage.h>

#include "driver_messages.hpp"

// Recordings as rosbag2 writes them, message by message as the standard of CDR has it.
namespace lidar_mapping::test {

/// Numbers are aligned to their size, counted from behind the head of four bytes.
class CdrWriter {
 public:
  CdrWriter() : bytes_{0, 1, 0, 0} {}

  template <typename Number>
  void number(Number value) {
    while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back(0);
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof value);
  }
  template <typename... Numbers>
  void numbers(Numbers... values) {
    (number(values), ...);
  }
  void text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.insert(bytes_.end(), value.c_str(), value.c_str() + value.size() + 1);
  }
  template <typename Array>
  void array(const Array& values) {
    for (const auto& value : values) number(value);
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  void header(const std_msgs::Header& header) {
    stamp(header.stamp);
    text(header.frame_id);
  }
  void stamp(const ros::Time& time) {
    number(static_cast<std::int32_t>(time.sec));
    number(time.nsec);
  }
  template <typename Vector>
  void vector(const Vector& v) {
    numbers(v.x, v.y, v.z);
  }
  template <typename Quaternion>
  void quaternion(const Quaternion& q) {
    numbers(q.x, q.y, q.z, q.w);
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

inline void write(CdrWriter& out, const sensor_msgs::PointCloud2& m) {
  out.header(m.header);
  out.numbers(m.height, m.width, static_cast<std::uint32_t>(m.fields.size()));
  for (const auto& field : m.fields) {
    out.text(field.name);
    out.numbers(field.offset, field.datatype, field.count);
  }
  out.numbers(m.is_bigendian, m.point_step, m.row_step, static_cast<std::uint32_t>(m.data.size()));
  out.array(m.data);
  out.number(m.is_dense);
}

inline void write(CdrWriter& out, const sensor_msgs::Imu& m) {
  out.header(m.header);
  out.quaternion(m.orientation);
  out.array(m.orientation_covariance);
  out.vector(m.angular_velocity);
  out.array(m.angular_velocity_covariance);
  out.vector(m.linear_acceleration);
  out.array(m.linear_acceleration_covariance);
}

inline void write(CdrWriter& out, const sensor_msgs::NavSatFix& m) {
  out.header(m.header);
  out.numbers(m.status.status, m.status.service, m.latitude, m.longitude, m.altitude);
  out.array(m.position_covariance);
  out.number(m.position_covariance_type);
}

inline void write(CdrWriter& out, const geometry_msgs::TwistStamped& m) {
  out.header(m.header);
  out.vector(m.twist.linear);
  out.vector(m.twist.angular);
}

inline void write(CdrWriter& out, const nav_msgs::Odometry& m) {
  out.header(m.header);
  out.text(m.child_frame_id);
  out.vector(m.pose.pose.position);
  out.quaternion(m.pose.pose.orientation);
  out.array(m.pose.covariance);
  out.vector(m.twist.twist.linear);
  out.vector(m.twist.twist.angular);
  out.array(m.twist.covariance);
}

inline void write(CdrWriter& out, const tf2_msgs::TFMessage& m) {
  out.number(static_cast<std::uint32_t>(m.transforms.size()));
  for (const auto& transform : m.transforms) {
    out.header(transform.header);
    out.text(transform.child_frame_id);
    out.vector(transform.transform.translation);
    out.quaternion(transform.transform.rotation);
  }
}

inline void write(CdrWriter& out, const LivoxMessage<LivoxDriver::kTwo>& m) {
  out.header(m.header);
  out.numbers(m.timebase, m.point_num, m.lidar_id);
  out.array(m.rsvd);
  out.number(static_cast<std::uint32_t>(m.points.size()));
  for (const LivoxPoint& p : m.points) {
    out.numbers(p.offset_time, p.x, p.y, p.z, p.reflectivity, p.tag, p.line);
  }
}

/// Name of a type in ROS 2: "sensor_msgs/msg/Imu".
template <typename Message>
std::string ros2_type() {
  std::string type = ros::message_traits::DataType<Message>::value();
  return type.insert(type.find('/'), "/msg");
}

/// A message as ROS 2 stores it.
template <typename Message>
std::vector<std::uint8_t> cdr_bytes(const Message& message) {
  CdrWriter out;
  write(out, message);
  return out.bytes();
}

/// A database of rosbag2.
class Ros2Writer {
 public:
  explicit Ros2Writer(const std::string& path) {
    if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) throw std::runtime_error(path);
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC); BEGIN");
  }
  ~Ros2Writer() {
    sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr);
    sqlite3_close(database_);
  }
  Ros2Writer(const Ros2Writer&) = delete;
  Ros2Writer& operator=(const Ros2Writer&) = delete;

  template <typename Message>
  void add(const std::string& topic, const ros::Time& recorded, const Message& message) {
    add_bytes(topic, ros2_type<Message>(), recorded, cdr_bytes(message));
  }
  void add_bytes(const std::string& topic, const std::string& type, const ros::Time& recorded,
                 const std::vector<std::uint8_t>& bytes, const std::string& format = "cdr") {
    const int id = topic_id(topic, type, format);
    sqlite3_stmt* row = nullptr;
    sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1,
                       &row, nullptr);
    sqlite3_bind_int(row, 1, id);
    sqlite3_bind_int64(row, 2, static_cast<std::int64_t>(recorded.toNSec()));
    sqlite3_bind_blob(row, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
    sqlite3_step(row);
    sqlite3_finalize(row);
  }

 private:
  void run(const std::string& text) {
    if (sqlite3_exec(database_, text.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database_));
    }
  }
  int topic_id(const std::string& topic, const std::string& type, const std::string& format) {
    const auto found = topics_.find(topic);
    if (found != topics_.end()) return found->second;
    const int id = static_cast<int>(topics_.size()) + 1;
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ",'" + topic + "','" + type + "','" +
        format + "','')");
    topics_[topic] = id;
    return id;
  }

  sqlite3* database_ = nullptr;
  std::map<std::string, int> topics_;
};

}  // namespace lidar_mapping::test
