// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <pcl/registration/registration.h>

#include "lidar_mapping/registration/registration.hpp"

#include "pcl_methods/pcl_clouds.hpp"

namespace lidar_mapping::registration {

/// Common part of PCL's methods: conversion, refusal of empty clouds, and an own test of
/// convergence, because PCL reports a search as converged whose iterations ran out.
class PclRegistration : public Registration {
 public:
  void set_target(const PointCloud& target) final;
  RegistrationResult align(const PointCloud& source, const Pose& T_target_source_guess) final;

 protected:
  using PclMethod = pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>;
  struct Outcome {
    bool converged = false;
    int iterations = 0;
  };
  explicit PclRegistration(double fitness_max_range) : fitness_max_range_(fitness_max_range) {}

 private:
  virtual PclMethod& method() = 0;
  /// Of the last call of method().align().
  virtual Outcome outcome() = 0;

  double fitness_max_range_;
  bool has_target_ = false;
  /// PCL's methods turn about the target's origin, in single precision: it is moved to the middle.
  Pose T_target_middle_;
};

std::unique_ptr<Registration> make_pcl_ndt(const RegistrationConfig& config);
std::unique_ptr<Registration> make_icp(const RegistrationConfig& config);
std::unique_ptr<Registration> make_gicp(const RegistrationConfig& config);

}  // namespace lidar_mapping::registration
