#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/preprocessing_config.hpp"

namespace lidar_mapping::preprocessing {

/// What is told of a cloud, without its points.
struct CloudSummary {
  Stamp stamp = 0;
  std::string frame_id;  ///< as the message has it
  std::size_t points = 0;
  std::string fields;
  std::string time_field;  ///< empty if there is none
  std::string time_unit;
  bool absolute_times = false;
  bool foreign_clock = false;
  double first_time = 0.0;  ///< s
  double last_time = 0.0;
};

/// One line about an input, and what is wrong with it, each with a remedy.
struct InputReport {
  std::string input;  ///< points, imu, velocity, gnss
  std::string found;
  std::vector<std::string> faults;
};

/// Looks at what sensors send before anybody maps with it: rates, frames, units, times, gravity,
/// fixes. It judges the messages as they come, not what preprocessing makes of them.
class InputDoctor {
 public:
  explicit InputDoctor(const PreprocessingConfig& config) : config_(config) {}

  void see_scan(const CloudSummary& cloud);
  void see_imu(const ImuSample& sample, const std::string& frame_id);
  void see_velocity(const VelocitySample& sample, const std::string& frame_id);
  void see_gnss(const GnssFix& fix, const std::string& frame_id);

  /// Points, imu, velocity, gnss. An input that never came is a fault of the points only.
  std::vector<InputReport> report(const ExtrinsicLookup& lookup) const;

 private:
  /// What the headers of a topic say.
  struct Flow {
    std::size_t count = 0;
    std::size_t backward = 0;
    Stamp first = 0;
    Stamp newest = 0;
    Stamp longest_gap = 0;
    Stamp gap_begin = 0;
    std::string frame_id;

    void see(Stamp stamp, const std::string& frame);
    double rate() const;
  };

  InputReport begin(const std::string& input, const Flow& flow,
                    const ExtrinsicLookup& lookup) const;
  InputReport points_report(const ExtrinsicLookup& lookup) const;
  void judge_times(InputReport& report) const;
  InputReport imu_report(const ExtrinsicLookup& lookup) const;
  InputReport velocity_report(const ExtrinsicLookup& lookup) const;
  InputReport gnss_report(const ExtrinsicLookup& lookup) const;
  void judge_jumps(InputReport& report) const;
  void judge_noise(InputReport& report) const;

  PreprocessingConfig config_;
  Flow points_flow_, imu_flow_, velocity_flow_, gnss_flow_, good_fix_flow_;
  CloudSummary cloud_;  ///< the last with points
  Eigen::Vector3d sum_of_accelerations_ = Eigen::Vector3d::Zero();
  double fastest_turn_ = 0.0;
  bool has_orientation_ = false;
  std::vector<ImuSample> imu_;
  std::vector<VelocitySample> velocity_;
  std::vector<GnssFix> fixes_;  ///< good ones
  std::map<std::string, std::size_t> bad_fixes_;
  bool covariance_known_ = true;
};

}  // namespace lidar_mapping::preprocessing
