// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/input_doctor.hpp"

#include "examinations.hpp"
#include "interpolation.hpp"
#include "local_frame.hpp"
#include "velocity_check.hpp"

namespace lidar_mapping::preprocessing {

struct InputDoctor::Records {
  PointsRecord points;
  ImuRecord imu;
  VelocityRecord velocity;
  GnssRecord gnss;
};

InputDoctor::InputDoctor(const PreprocessingConfig& config)
    : config_(config), records_(std::make_unique<Records>()) {}
InputDoctor::~InputDoctor() = default;

void InputDoctor::see_scan(const CloudSummary& cloud) {
  records_->points.flow.see(cloud.stamp, cloud.frame_id);
  if (cloud.points == 0) return;
  records_->points.cloud = cloud;
  records_->points.seam.add(cloud);
  if (cloud.delay) records_->points.delays.push_back(*cloud.delay);
}

void InputDoctor::see_imu(const ImuSample& sample, const std::string& frame_id) {
  records_->imu.flow.see(sample.stamp, frame_id);
  if (is_plausible(sample)) records_->imu.keep(sample);
}

void InputDoctor::see_velocity(const VelocitySample& sample, const std::string& frame_id) {
  records_->velocity.flow.see(sample.stamp, frame_id);
  if (is_plausible(sample)) records_->velocity.keep(sample);
}

void InputDoctor::see_gnss(const GnssFix& fix, const std::string& frame_id) {
  GnssRecord& gnss = records_->gnss;
  gnss.flow.see(fix.stamp, frame_id);
  const std::string problem = problem_of(fix, config_);
  if (!problem.empty()) {
    ++gnss.refused[problem.substr(0, problem.find(" of "))];
    return;
  }
  gnss.good.flow.see(fix.stamp, frame_id);
  gnss.covariance_known = gnss.covariance_known && fix.covariance.has_value();
  gnss.good.keep(fix);
}

std::vector<InputReport> InputDoctor::report(const ExtrinsicLookup& lookup) const {
  const Records& r = *records_;
  // Fixes are not compared with speeds in another unit.
  const auto scale = speed_scale(r.velocity, r.gnss, config_);
  const bool compares = !scale || is_true_scale(*scale);
  return {examine(r.points, lookup, config_), examine(r.imu, r.velocity, lookup, config_),
          examine(r.velocity, r.gnss, lookup, config_),
          examine(r.gnss, r.imu, compares ? r.velocity : VelocityRecord{}, lookup, config_)};
}

}  // namespace lidar_mapping::preprocessing
