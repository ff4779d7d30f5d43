// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"
#include "lidar_mapping/preprocessing/check_diagnostic.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"

namespace lidar_mapping::preprocessing {

/// The name of the frame as tf2 uses it: without a leading slash.
std::string without_leading_slash(const std::string& frame_id);

/// Statistics of the headers of a topic.
struct TopicStatistics {
  /// Four minutes at 200 Hz; chosen, bounds the memory.
  static constexpr std::size_t kMaxDelays = 50000;

  std::size_t count = 0;
  std::size_t backward = 0;    ///< stamps that are not later than all previous ones
  std::size_t repeated = 0;    ///< stamps that are equal to the one before
  std::size_t steps_back = 0;  ///< stamps that are earlier than the one before
  Stamp longest_step_back = 0;
  Stamp first = 0;
  Stamp newest = 0;
  Stamp longest_gap = 0;
  Stamp gap_begin = 0;
  std::string frame_id;        ///< of the first message
  std::string other_frame_id;  ///< of the first message with another one; empty without
  std::vector<double> delays;  ///< s from the stamps to the deliveries, where known, up to a limit

  /// `delay`: s from the stamp to the delivery, if it is known.
  void add(Stamp stamp, const std::string& frame, std::optional<double> delay = std::nullopt);
  double rate() const;        ///< Hz
  bool was_set_back() const;  ///< the clock, once or a few times
  std::string frame() const { return without_leading_slash(frame_id); }

 private:
  Stamp last_ = 0;  ///< stamp of the last message
};

/// The messages of a sensor: statistics of their headers and, up to a limit, the usable samples.
template <typename Sample>
struct SensorRecord {
  /// Four minutes at 200 Hz; chosen, bounds the memory.
  static constexpr std::size_t kMaxSamples = 50000;

  TopicStatistics topic;
  std::vector<Sample> samples;

  void add_sample(const Sample& sample) {
    if (samples.size() < kMaxSamples) samples.push_back(sample);
  }
};

/// Checks the headers of an input: rate, frame, transform, stamps.
InputReport check_headers(const std::string& input, const TopicStatistics& topic,
                          const ExtrinsicLookup& lookup);

/// Adds a fault if the transform of that frame is longer than a vehicle.
void check_place(const std::string& frame, const ExtrinsicLookup& lookup, InputReport& report);

void add_fault(InputReport& report, const std::string& text, const std::string& remedy);
void add_warning(InputReport& report, const std::string& text, const std::string& remedy);

}  // namespace lidar_mapping::preprocessing
