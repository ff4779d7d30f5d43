// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include "lidar_mapping/registration/registration.hpp"

#include "scenes.hpp"

namespace lidar_mapping::registration {

inline const Method kAllMethods[] = {Method::kNdt, Method::kVgicp, Method::kPclNdt, Method::kIcp,
                                     Method::kGicp};

inline Pose pose_of(double x, double y, double z, double roll, double pitch, double yaw) {
  Vector6d d;
  d << x, y, z, roll, pitch, yaw;
  return perturbed(Pose::Identity(), d);
}

inline double distance_between(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm();
}
inline double angle_between(const Pose& a, const Pose& b) {
  return rotation_angle(a.rotation.conjugate() * b.rotation);
}

/// Two samples of one street corner, the second one seen from T_target_source.
struct Scene {
  Pose T_target_source = pose_of(1.2, -0.4, 0.05, 0.01, -0.02, 0.15);
  PointCloud target;
  PointCloud source;
};

inline Scene make_scene(double noise, unsigned seed = 1) {
  Scene scene;
  scene.target = test::street_corner(seed, 20000, noise);
  scene.source =
      transformed(test::street_corner(seed + 100, 4000, noise), scene.T_target_source.inverse());
  return scene;
}

/// A test that every method has to pass.
class MethodTest : public testing::TestWithParam<Method> {
 protected:
  static RegistrationConfig config() {
    RegistrationConfig config;
    config.method = GetParam();
    return config;
  }
  static RegistrationResult aligned(const PointCloud& target, const PointCloud& source,
                                    const Pose& guess, const RegistrationConfig& config) {
    const auto registration = make_registration(config);
    registration->set_target(target);
    return registration->align(source, guess);
  }
};

/// Names of the instances of a MethodTest.
inline std::string method_name(const testing::TestParamInfo<Method>& instance) {
  return to_string(instance.param);
}

}  // namespace lidar_mapping::registration
