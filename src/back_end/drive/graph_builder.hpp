// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include "drive/drive_graph.hpp"

namespace lidar_mapping::back_end {

/// Measurements that arrived before their key frame. The oldest is dropped above a limit.
template <typename Value>
class PendingMeasurements {
 public:
  void add(Stamp stamp, const Value& value) {
    values_[stamp] = value;
    if (values_.size() > kLimit) values_.erase(values_.begin());
  }

  std::optional<Value> extract(Stamp stamp) {
    const auto found = values_.find(stamp);
    if (found == values_.end()) return std::nullopt;
    std::optional<Value> value = found->second;
    values_.erase(found);
    return value;
  }

 private:
  /// Values; chosen, bounds the memory if their key frames never come.
  static constexpr std::size_t kLimit = 1000;

  std::map<Stamp, Value> values_;
};

/// Number of data that arrived since the last solution.
struct NewDataCounts {
  int key_frames = 0;
  int loops = 0;
  int gnss = 0;
};

/// A loop with the nodes of its key frames; empty if it does not fit the drive (BackEnd::fits()).
std::optional<DriveLoop> placed(const Loop& loop, const DriveGraph& drive);

/// Adds key frames, loops and measurements to a drive. It checks them and assigns measurements to
/// the key frame with the same stamp, in either order of arrival.
class GraphBuilder {
 public:
  explicit GraphBuilder(const BackEndConfig& config) : config_(config) {}

  void add_key_frame(const KeyFrame& key_frame, DriveGraph& drive);
  bool add_loop(const Loop& loop, DriveGraph& drive);
  void add_gnss(const GnssPosition& position, DriveGraph& drive);
  void add_imu(const ImuSample& sample, DriveGraph& drive);
  void add_floor(const Floor& floor, DriveGraph& drive);

  const NewDataCounts& new_data() const { return new_data_; }
  /// After a solution: what arrived while it was computed, or was not part of it.
  void set_new_data(const NewDataCounts& counts) { new_data_ = counts; }

 private:
  template <typename Value>
  void attach_or_store(const Value& value, PendingMeasurements<Value>& pending, DriveGraph& drive);
  template <typename Value>
  void attach_pending(Stamp stamp, PendingMeasurements<Value>& pending, DriveGraph& drive);
  void attach(const GnssPosition& position, int node, DriveGraph& drive);
  void attach(const ImuSample& sample, int node, DriveGraph& drive);
  void attach(const Floor& floor, int node, DriveGraph& drive);

  /// Adds what a node needs whose motion from the previous one is known.
  void add_step(const KeyFrame& key_frame, const DriveNode& previous, DriveNode& node);
  void begin_segment(DriveGraph& drive);

  BackEndConfig config_;
  NewDataCounts new_data_;
  std::map<Stamp, int> at_stamp_;
  PendingMeasurements<GnssPosition> pending_gnss_;
  PendingMeasurements<ImuSample> pending_imu_;
  PendingMeasurements<Floor> pending_floors_;
  std::uint32_t newest_segment_ = 0;  ///< number that the front end gave to the segment
  double distance_in_segment_ = 0.0;  ///< distance travelled in the newest segment, m
};

}  // namespace lidar_mapping::back_end
