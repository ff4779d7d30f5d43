// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include <pcl/registration/registration.h>

#include "lidar_mapping/registration/registration.hpp"

#include "pcl_methods/pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// A method of PCL with what all of them need: conversion, refusal of empty clouds, and an own test
/// of convergence, because PCL reports a search as converged whose iterations ran out.
class PclRegistration : public Registration {
 public:
  using PclMethod = pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>;
  struct Outcome {
    bool converged = false;
    int iterations = 0;
  };
  /// `outcome` tells that of the last call of method->align().
  PclRegistration(std::shared_ptr<PclMethod> method, std::function<Outcome()> outcome,
                  double fitness_max_range);

  void set_target(const PointCloud& target) override;
  RegistrationResult align(const PointCloud& source, const Pose& T_target_source_guess) override;

 private:
  std::shared_ptr<PclMethod> method_;
  std::function<Outcome()> outcome_;
  double fitness_max_range_;
  bool has_target_ = false;
  /// PCL's methods turn about the target's origin, in single precision: it is moved to the middle.
  Pose T_target_middle_;
};

std::unique_ptr<Registration> make_pcl_ndt(const RegistrationConfig& config);
std::unique_ptr<Registration> make_icp(const RegistrationConfig& config);
std::unique_ptr<Registration> make_gicp(const RegistrationConfig& config);

}  // namespace lidar_mapping::registration
