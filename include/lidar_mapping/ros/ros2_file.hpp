// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/ros/chunked_recording.hpp"

struct sqlite3;

namespace lidar_mapping::ros_border {

struct Ros2Type;

/// A message of a ROS 2 recording, in the serialisation of ROS 1.
struct Ros2Message {
  Stamp recorded = 0;                               ///< when it was recorded
  const BagConnection* connection = nullptr;        ///< lives as long as the file
  std::shared_ptr<std::vector<std::uint8_t>> data;  ///< null if the message is damaged
  std::string damage;                               ///< what is wrong with it
};

/// A recording of ROS 2 in SQLite (.db3 of rosbag2), or some topics of it. Types of message that
/// are alike in ROS 1 are converted, so that nothing of ROS 2 is needed; of others only the names
/// are known. Throws FileError with the reason and the remedy.
class Ros2File {
 public:
  /// Whether the file is such a database. Throws FileError with the remedy for a file that is
  /// compressed as a whole.
  static bool is_one(const std::string& path);

  /// Reads the list of these topics; topics that do not exist are ignored.
  explicit Ros2File(const std::string& path, const WantedTopics& topics = std::nullopt);
  ~Ros2File();

  /// Topics by the numbers that the database gives them, with the types' names and MD5 sums of
  /// ROS 1; the sum is empty for types that are not read.
  const std::map<std::int64_t, BagConnection>& connections() const { return connections_; }
  /// Times of the first and the last message of the topics; empty if there is none. Those that do
  /// not fit into a time of ROS are left out here; next() gives the nearest one for them.
  std::optional<std::pair<Stamp, Stamp>> times() const;

  /// Continues with the first message that was recorded at or after `stamp`.
  void skip_to(Stamp stamp);
  /// When the next message was recorded; empty at the end.
  std::optional<Stamp> next_time();
  /// The next message, which has to be there, in the order of the times.
  Ros2Message next();

 private:
  class Statement;

  void read_topics(const WantedTopics& topics);
  void count_messages();
  std::string of_topics() const;
  void begin_reading();
  [[noreturn]] void fail(const std::string& reason) const;

  std::string path_;
  std::shared_ptr<sqlite3> database_;
  std::map<std::int64_t, BagConnection> connections_;
  std::map<std::int64_t, const Ros2Type*> types_;   ///< those that are read
  Stamp from_ = std::numeric_limits<Stamp>::min();  ///< of the first message that is read
  std::unique_ptr<Statement> reading_;              ///< null before the first message is asked for
  bool has_row_ = false;
};

}  // namespace lidar_mapping::ros_border
