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
  records_->points.topic.add(cloud.stamp, cloud.frame_id);
  records_->points.damaged_packets += cloud.damaged_packets;
  if (cloud.points == 0) {
    ++records_->points.empty;
    return;
  }
  records_->points.cloud = cloud;
  records_->points.seam.add(cloud);
  if (cloud.delay) records_->points.delays.push_back(*cloud.delay);
}

void InputValidator::add_imu(const ImuSample& sample, const std::string& frame_id) {
  records_->imu.topic.add(sample.stamp, frame_id);
  if (is_plausible(sample)) records_->imu.add_sample(sample);
}

void InputValidator::add_velocity(const VelocitySample& sample, const std::string& frame_id) {
  records_->velocity.topic.add(sample.stamp, frame_id);
  if (is_plausible(sample)) records_->velocity.add_sample(sample);
}

void InputValidator::add_gnss(const GnssFix& fix, const std::string& frame_id) {
  GnssRecord& gnss = records_->gnss;
  gnss.topic.add(fix.stamp, frame_id);
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
  // Fixes are not compared with speeds in another unit.
  const auto scale = speed_scale(r.velocity, r.gnss, config_);
  const bool compares = !scale || is_true_scale(*scale);
  return {check(r.points, lookup, config_), check(r.imu, r.velocity, lookup, config_),
          check(r.velocity, r.gnss, lookup, config_),
          check(r.gnss, r.imu, compares ? r.velocity : VelocityRecord{}, lookup, config_)};
}

}  // namespace lidar_mapping::preprocessing
