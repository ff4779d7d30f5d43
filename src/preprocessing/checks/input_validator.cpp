// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/input_validator.hpp"

#include "checks/input_checks.hpp"
#include "checks/velocity_check.hpp"
#include "gnss/local_frame.hpp"
#include "motion/interpolation.hpp"

namespace lidar_mapping::preprocessing {

struct InputValidator::Records {
  PointsRecord points;
  ImuRecord imu;
  VelocityRecord velocity;
  GnssRecord gnss;
};

InputValidator::InputValidator(const PreprocessingConfig& config)
    : config_(config), records_(std::make_unique<Records>()) {}
InputValidator::~InputValidator() = default;

void InputValidator::add_scan(const CloudSummary& cloud) {
  records_->points.topic.add(cloud.stamp, cloud.frame_id, cloud.delay);
  records_->points.damaged_packets += cloud.damaged_packets;
  if (cloud.points == 0) {
    ++records_->points.empty;
    return;
  }
  records_->points.cloud = cloud;
  if (!cloud.time_field.empty()) ++records_->points.timed;
  if (cloud.foreign_clock) ++records_->points.of_other_clock;
  // Of two sensors on one topic the ends of the sweeps do not join.
  if (cloud.frame_id == records_->points.topic.frame_id) records_->points.seam.add(cloud);
}

void InputValidator::add_imu(const ImuSample& sample, const std::string& frame_id,
                             std::optional<double> delay) {
  records_->imu.topic.add(sample.stamp, frame_id, delay);
  if (is_plausible(sample)) records_->imu.add_sample(sample);
}

void InputValidator::add_velocity(const VelocitySample& sample, const std::string& frame_id,
                                  std::optional<double> delay) {
  records_->velocity.topic.add(sample.stamp, frame_id, delay);
  if (is_plausible(sample)) records_->velocity.add_sample(sample);
}

void InputValidator::add_gnss(const GnssFix& fix, const std::string& frame_id,
                              std::optional<double> delay) {
  GnssRecord& gnss = records_->gnss;
  gnss.topic.add(fix.stamp, frame_id, delay);
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) {
    RefusedFixes& refused = gnss.refused[kind_of_problem(problem)];
    if (refused.count++ == 0) refused.problem = problem;
    return;
  }
  gnss.usable.topic.add(fix.stamp, frame_id);
  gnss.covariance_known = gnss.covariance_known && fix.covariance.has_value();
  gnss.usable.add_sample(fix);
}

std::vector<InputReport> InputValidator::report(const ExtrinsicLookup& lookup) const {
  const Records& r = *records_;
  // Fixes are not compared with anything if they are mirrored, nor with speeds in another unit.
  const bool mirrored = fixes_are_mirrored(r.gnss, r.imu, lookup, config_);
  GnssRecord gnss = r.gnss;
  if (mirrored) gnss.usable.samples.clear();
  const auto scale = speed_scale(r.velocity, gnss, config_);
  const bool compares = !scale || is_true_scale(*scale);
  std::vector<InputReport> reports = {
      check(r.points, lookup, config_), check(r.imu, r.velocity, lookup, config_),
      check(r.velocity, gnss, lookup, config_),
      check(gnss, r.imu, compares ? r.velocity : VelocityRecord{}, lookup, config_)};
  if (compares && reports[2].diagnostics.empty()) {
    check_accelerations(r.velocity, r.imu, lookup, config_, reports[2]);
  }
  if (mirrored) {
    add_fault(reports[3], "the fixes turn to the left where the IMU turns to the right",
              "latitude and longitude are swapped, or the IMU's z axis points down; correct the "
              "driver or the IMU's transform");
  }
  const TopicStatistics& points = r.points.topic;
  check_clock(r.imu.topic, points, "imu_time_offset", config_.imu_time_offset, reports[1]);
  check_clock(r.velocity.topic, points, "velocity_time_offset", config_.velocity_time_offset,
              reports[2]);
  check_clock(r.gnss.topic, points, "gnss_time_offset", config_.gnss_time_offset, reports[3]);
  return reports;
}

}  // namespace lidar_mapping::preprocessing
