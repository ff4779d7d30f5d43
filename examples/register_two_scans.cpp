// SPDX-License-Identifier: BSD-3-Clause
// Registers one scan onto another one (PCD files) and prints the pose that was found.
//   register_two_scans TARGET.pcd SOURCE.pcd [METHOD]

#include <cstdio>
#include <exception>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/registration/registration.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

using namespace lidar_mapping;

int main(int argc, char** argv) try {
  if (argc < 3 || argc > 4) {
    throw InputError("usage: register_two_scans TARGET.pcd SOURCE.pcd [METHOD]");
  }
  // Parameters are given as YAML text, a YAML file or by the fields of the configuration.
  const std::string method = argc == 4 ? argv[3] : "NDT";
  const auto config = config::load<registration::RegistrationConfig>(
      {config::parse_yaml("registration_method: " + method, "command line")});

  const auto matcher = registration::make_registration(config);
  matcher->set_target(session::read_pcd(argv[1]));
  const Pose guess = Pose::Identity();  // T_target_source, as far as it is known
  const auto result = matcher->align(session::read_pcd(argv[2]), guess);

  const Eigen::Vector3d& t = result.T_target_source.translation;
  const Eigen::Vector3d r = log_so3(result.T_target_source.rotation);
  std::printf("converged %d after %d iterations, overlap %.3f, mean squared distance %.5f m^2\n",
              result.converged ? 1 : 0, result.iterations, result.overlap, result.fitness);
  std::printf("translation %.4f %.4f %.4f m\n", t.x(), t.y(), t.z());
  std::printf("rotation vector %.5f %.5f %.5f rad\n", r.x(), r.y(), r.z());
  if (!result.hessian.isZero()) {
    const Vector6d sigma = result.hessian.inverse().diagonal().cwiseSqrt();
    std::printf("standard deviations %.4f %.4f %.4f m, %.6f %.6f %.6f rad\n", sigma[0], sigma[1],
                sigma[2], sigma[3], sigma[4], sigma[5]);
  }
  return result.converged ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
