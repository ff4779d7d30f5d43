// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include "motion/sample_buffer.hpp"
#include "stamp_guard.hpp"

namespace lidar_mapping::preprocessing {

enum class Insertion { kInserted, kRefused, kTimeWentBack };

/// How far the data have come.
struct Progress {
  Stamp newest = 0;   ///< the latest stamp of all data
  Stamp latency = 0;  ///< so much later than its stamp a sample may still come
};

/// Whether scans and fixes that lack data go on waiting for these.
enum class Waiting { kGoesOn, kEnds };

/// The samples of one sensor, and its state as far as it follows from the stamps.
template <typename Sample>
class SensorStream {
 public:
  SensorStream(std::string name, bool enabled, double max_gap)
      : name_(std::move(name)),
        enabled_(enabled),
        max_gap_(from_seconds(max_gap)),
        buffer_(from_seconds(kHorizon), kCapacity) {}

  /// Rejects duplicates and samples that are older than all samples in the buffer. If the stamps
  /// have jumped back so far that the recording must have started again, nothing is inserted, and
  /// the result is kTimeWentBack.
  Insertion insert(Sample sample, const std::string& frame_id) {
    if (!buffer_.empty() && sample.stamp < buffer_.newest().stamp - kJumpBack) {
      return Insertion::kTimeWentBack;
    }
    if (frame_id != frame_id_) buffer_.clear();  // samples of another sensor
    frame_id_ = frame_id;
    return buffer_.insert(std::move(sample)) ? Insertion::kInserted : Insertion::kRefused;
  }

  /// True if a sample at or after `until` may still arrive: the sensor is active, or has not had
  /// enough time for a first sample.
  bool may_still_deliver(Stamp until, const Progress& progress) const {
    if (!enabled_ || given_up_) return false;
    const bool is_too_late = progress.newest >= until + progress.latency;
    if (buffer_.empty()) return !is_too_late;
    if (buffer_.newest().stamp >= until || is_too_late) return false;
    return buffer_.newest().stamp > progress.newest - from_seconds(kSilence) - progress.latency;
  }

  /// Stops waiting for a sensor that has never delivered a sample, until it does.
  void give_up_if_silent() { given_up_ = buffer_.empty(); }

  auto around(Stamp stamp) const { return buffer_.around(stamp, max_gap_); }
  const Sample* before(Stamp stamp) const { return buffer_.before(stamp, max_gap_); }
  const SampleBuffer<Sample>& buffer() const { return buffer_; }
  const std::string& frame_id() const { return frame_id_; }
  const std::string& name() const { return name_; }
  void clear() {
    buffer_.clear();
    given_up_ = false;
  }

 private:
  // s of samples. Chosen: longer than any scan waits (30 scans, 3 s at 10 Hz).
  static constexpr double kHorizon = 20.0;
  static constexpr std::size_t kCapacity = 20000;  // samples of kHorizon at 1 kHz
  // s without a sample, after which the sensor is not active any more. Chosen: most send at 10 Hz
  // or more, and scans must not wait for one that has ended.
  static constexpr double kSilence = 1.0;

  std::string name_;
  bool enabled_;
  bool given_up_ = false;
  Stamp max_gap_;
  std::string frame_id_;
  SampleBuffer<Sample> buffer_;
};

}  // namespace lidar_mapping::preprocessing
