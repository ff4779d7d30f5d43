// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <type_traits>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/session/session.hpp"

#include "database.hpp"

namespace lidar_mapping::session {

/// Of a probability; negative by the format, see session_schema.cpp.
constexpr double kUnknownProbability = -1.0;

/// Writes the fields of a value one after the other as the cells of a row.
class RowWriter {
 public:
  void process(std::int64_t value) { cells.emplace_back(value); }
  void process(std::uint32_t value) { cells.emplace_back(std::int64_t{value}); }
  void process(std::size_t value) { cells.emplace_back(static_cast<std::int64_t>(value)); }
  void process(int value) { cells.emplace_back(std::int64_t{value}); }
  void process(bool value) { cells.emplace_back(std::int64_t{value ? 1 : 0}); }
  void process(double value) { cells.emplace_back(value); }
  void process(const std::string& value) { cells.emplace_back(value); }
  void process(LoopSource value) { cells.emplace_back(std::string(to_string(value))); }
  void process(Verdict value) { cells.emplace_back(std::string(to_string(value))); }
  void process(const Eigen::Vector3d& value) { append(cells, value); }
  void process(const Pose& value) { append(cells, value); }
  void process(const Covariance6& value) { append(cells, to_blob(value)); }
  void process(const Eigen::Matrix3d& value) { append(cells, to_blob(value)); }
  void process(const std::optional<Eigen::Quaterniond>& value) {
    if (value) {
      append(cells, *value);
    } else {
      cells.insert(cells.end(), 4, nullptr);
    }
  }
  void process(std::optional<double> value) {
    cells.emplace_back(value.value_or(kUnknownProbability));
  }
  void process(const std::vector<Eigen::Vector3d>& values) {
    Blob blob;
    for (const Eigen::Vector3d& value : values) {
      blob.insert(blob.end(), value.data(), value.data() + 3);
    }
    append(cells, blob);
  }
  /// Only the number of points of a cloud.
  void process(const PointCloudPtr& cloud) { process(cloud ? cloud->size() : std::size_t{0}); }

  Cells cells;
};

/// Reads the fields of a value from the cells of a row.
class RowReader {
 public:
  explicit RowReader(Statement& row) : row_(row) {}

  /// All integers of this type are stamps; the limit keeps their differences within the type.
  void process(std::int64_t& value) {
    constexpr std::int64_t kLatest = from_seconds(kMaxTime);  // half of the largest integer
    value = row_.read_integer(-kLatest, kLatest);
  }
  void process(std::uint32_t& value) { read_number(value); }
  void process(std::size_t& value) { read_number(value); }
  void process(int& value) { read_number(value); }
  void process(bool& value) { value = row_.read_integer() != 0; }
  void process(double& value) { value = row_.read_real(); }
  void process(std::string& value) { value = row_.read_text(); }
  void process(LoopSource& value) { read_word(value, loop_source_from); }
  void process(Verdict& value) { read_word(value, verdict_from); }
  void process(LoopDecision& value) { read_word(value, loop_decision_from); }
  void process(Eigen::Vector3d& value) { value = row_.read_vector(); }
  void process(Pose& value) { value = row_.read_pose(); }
  void process(Covariance6& value) { value = to_matrix<Covariance6>(row_.read_blob(36)); }
  void process(Eigen::Matrix3d& value) { value = to_matrix<Eigen::Matrix3d>(row_.read_blob(9)); }
  void process(std::optional<Eigen::Quaterniond>& value) {
    value.reset();
    if (row_.next_is_null()) return row_.skip(4);
    value = row_.read_quaternion();
  }
  void process(std::optional<double>& value) {
    const double stored = row_.read_real();
    value = stored < 0.0 ? std::nullopt : std::optional(stored);
  }
  void process(std::vector<Eigen::Vector3d>& values) {
    const Blob blob = row_.read_blob();
    values.clear();
    for (std::size_t i = 0; i + 3 <= blob.size(); i += 3) {
      values.emplace_back(blob[i], blob[i + 1], blob[i + 2]);
    }
  }
  void process(PointCloudPtr&) { row_.skip(1); }

 private:
  template <typename Integer>
  void read_number(Integer& value) {
    constexpr auto kMaxValue = std::numeric_limits<Integer>::max();
    constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
    value = static_cast<Integer>(row_.read_integer(
        std::is_signed_v<Integer> ? std::int64_t{std::numeric_limits<int>::min()} : 0,
        sizeof(Integer) < sizeof(std::int64_t) ? static_cast<std::int64_t>(kMaxValue) : kLargest));
  }
  template <typename Value, typename FromWord>
  void read_word(Value& value, const FromWord& from_word) {
    const int column = row_.next_column();
    try {
      value = from_word(row_.read_text());
    } catch (const InputError& error) {
      row_.require(false, column, std::string("a word that is known (") + error.what() + ")");
    }
  }

  Statement& row_;
};

template <typename Value>
struct Row {};

// The columns of each table, defined once for writing (V is const) and reading. `each` takes the
// fields from left to right.

template <typename V, typename Each>
void visit(Row<KeyFrame>, V& v, Each each) {
  each(v.index, v.segment, v.stamp, v.T_odom_base, v.motion_covariance, v.degenerate_directions,
       v.cloud, v.doubtful);
}

template <typename V, typename Each>
void visit(Row<Loop>, V& v, Each each) {
  each(v.from, v.to, v.stamp, v.T_from_to, v.covariance, v.fitness, v.overlap, v.source);
}

template <typename V, typename Each>
void visit(Row<LoopVerdict>, V& v, Each each) {
  each(v.from, v.to, v.stamp, v.source, v.verdict, v.reason, v.distance, v.fitness, v.overlap,
       v.free_space_violation, v.horizontal_eigenvalue, v.innovation);
}

template <typename V, typename Each>
void visit(Row<GnssPosition>, V& v, Each each) {
  each(v.stamp, v.p_enu_antenna, v.covariance, v.p_base_antenna, v.R_enu_base);
}

template <typename V, typename Each>
void visit(Row<ImuSample>, V& v, Each each) {
  each(v.stamp, v.angular_velocity, v.linear_acceleration, v.orientation);
}

template <typename V, typename Each>
void visit(Row<Floor>, V& v, Each each) {
  each(v.stamp, v.found, v.normal, v.offset, v.covariance, v.inliers);
}

template <typename V, typename Each>
void visit(Row<ScanRecord>, V& v, Each each) {
  each(v.stamp, v.state, v.fitness, v.overlap, v.seconds, v.scans_dropped, v.unobserved_stddev,
       v.elevation_shift, v.probability);
}

template <typename V, typename Each>
void visit(Row<KeyFramePose>, V& v, Each each) {
  each(v.index, v.stamp, v.T_map_base);
}

template <typename V, typename Each>
void visit(Row<RevisionRecord>, V& v, Each each) {
  each(v.revision, v.key_frames, v.loops_used, v.loops_refused, v.gnss_used, v.gnss_refused,
       v.cost_before, v.cost_after, v.seconds);
}

template <typename V, typename Each>
void visit(Row<ScanOdometry>, V& v, Each each) {
  each(v.stamp, v.T_odom_base, v.drive);
}

/// Rows of loops and verdicts begin with an id, which the database gives them.
template <typename Value>
constexpr bool kHasId = std::is_same_v<Value, Loop> || std::is_same_v<Value, LoopVerdict>;

/// The cells of a value in the order of the columns of its table.
template <typename Value>
Cells to_cells(const Value& value) {
  RowWriter writer;
  if constexpr (kHasId<Value>) writer.cells.emplace_back(nullptr);
  visit(Row<Value>(), value, [&](const auto&... fields) { (writer.process(fields), ...); });
  return writer.cells;
}

/// The value of a row. The decision of a person follows a loop.
template <typename Value>
Value from_row(Statement& row) {
  if constexpr (kHasId<Value>) row.skip(1);
  RowReader reader(row);
  Value value;
  visit(Row<Value>(), value, [&](auto&... fields) { (reader.process(fields), ...); });
  if constexpr (std::is_same_v<Value, Loop>) reader.process(value.decision);
  return value;
}

}  // namespace lidar_mapping::session
