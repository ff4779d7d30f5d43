#pragma once

#include <deque>

#include "lidar_mapping/common/sensor_data.hpp"

namespace lidar_mapping::front_end {

/// The samples of an IMU of the last seconds, in the axes of base_link.
class ImuTrack {
 public:
  /// From now on so much is subtracted from the stamps of samples that come.
  void set_delay(Stamp delay) { delay_ = delay; }
  Stamp delay() const { return delay_; }
  /// Samples come in the order of their stamps; older ones are dropped.
  void add(const ImuStretch& stretch);
  /// Samples before `stamp` will not be asked for any more.
  void forget_before(Stamp stamp);
  void clear();

  bool empty() const { return samples_.empty(); }
  Stamp oldest() const { return samples_.front().stamp; }
  /// Whether both sensors were there all the time from `begin` to `end`, without a gap. A sample
  /// holds for a period beyond its stamp, and for the delay: what is late has not come yet.
  bool covers(Stamp begin, Stamp end) const;
  /// Whether a value stood at the largest that the sensor has ever shown: it shows no more.
  bool is_clipped(Stamp begin, Stamp end, Eigen::Vector3d ImuSample::*value) const;
  /// The value between two samples; the nearest one beyond the ends.
  ImuSample at(Stamp stamp) const;
  /// The samples in [begin, end], and those made up at both ends.
  std::vector<ImuSample> between(Stamp begin, Stamp end) const;
  const Eigen::Vector3d& p_base_imu() const { return p_base_imu_; }

 private:
  /// The largest value of each axis, and how long it has stood there.
  struct Limit {
    Eigen::Vector3d largest = Eigen::Vector3d::Zero();
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
  };

  void mark_clipped(const ImuSample& sample);

  std::deque<ImuSample> samples_;
  std::deque<bool> rate_clipped_, force_clipped_;
  Limit rate_, force_;
  Stamp delay_ = 0;
  Stamp period_ = 0;  ///< running mean
  Eigen::Vector3d p_base_imu_ = Eigen::Vector3d::Zero();
};

}  // namespace lidar_mapping::front_end
