// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/registration/registration.hpp"

#include "own_registration.hpp"
#include "pcl_methods/pcl_registration.hpp"

namespace lidar_mapping::registration {

std::unique_ptr<Registration> make_registration(const RegistrationConfig& config) {
  switch (implemented_by(config.method)) {
    case Method::kVgicp:
      return make_vgicp(config);
    case Method::kPclNdt:
      return make_pcl_ndt(config);
    case Method::kIcp:
      return make_icp(config);
    case Method::kGicp:
      return make_gicp(config);
    default:
      return make_ndt(config);
  }
}

}  // namespace lidar_mapping::registration
