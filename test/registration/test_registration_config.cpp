// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/registration/registration_config.hpp"

namespace lidar_mapping::registration {
namespace {

RegistrationConfig load_text(const std::string& text) {
  return config::load<RegistrationConfig>({config::parse_yaml(text, "test.yaml")});
}

// Parameters of the ancestors must not be read as something else, or silently ignored.
TEST(RegistrationConfig, ReadsTheParametersOfLidarLocalization) {
  const RegistrationConfig config =
      load_text("NDT: {res: 1.5, step_size: 0.2, trans_eps: 0.02, max_iter: 40}\n");
  EXPECT_EQ(config.resolution, 1.5);
  EXPECT_EQ(config.step_size, 0.2);
  EXPECT_EQ(config.transformation_epsilon, 0.02);
  EXPECT_EQ(config.max_iterations, 40);
}

TEST(RegistrationConfig, ReadsTheParametersOfHdlGraphSlam) {
  const RegistrationConfig config = load_text(
      "registration_method: GICP_OMP\nreg_resolution: 0.5\nreg_transformation_epsilon: 0.1\n"
      "reg_maximum_iterations: 20\nreg_max_correspondence_distance: 2\n"
      "reg_correspondence_randomness: 15\nreg_max_optimizer_iterations: 10\n"
      "reg_use_reciprocal_correspondences: true\nreg_nn_search_method: DIRECT7\n"
      "reg_num_threads: 2\n");
  EXPECT_EQ(config.neighbor_search, NeighborSearch::kDirect7);
  EXPECT_EQ(config.num_threads, 2);
  EXPECT_EQ(config.resolution, 0.5);
  EXPECT_EQ(config.transformation_epsilon, 0.1);
  EXPECT_EQ(config.max_iterations, 20);
  EXPECT_EQ(config.max_correspondence_distance, 2.0);
  EXPECT_EQ(config.correspondence_randomness, 15);
  EXPECT_EQ(config.max_optimizer_iterations, 10);
  EXPECT_TRUE(config.use_reciprocal_correspondences);
}

TEST(RegistrationConfig, SaysWhichMethodStandsForAForeignName) {
  const RegistrationConfig config = load_text("registration_method: GICP_OMP\n");
  EXPECT_EQ(implemented_by(config.method), Method::kGicp);
  EXPECT_EQ(describe_substitution(config),
            "registration_method GICP_OMP is hdl_graph_slam's; GICP does its work here");
  EXPECT_EQ(describe_substitution(load_text("registration_method: ICP\n")), "");
}

TEST(RegistrationConfig, KnowsTheMethodsOfHdlGraphSlam) {
  for (const auto& [name, method] :
       {std::pair("NDT_OMP", Method::kNdt), std::pair("FAST_GICP", Method::kVgicp),
        std::pair("FAST_VGICP", Method::kVgicp), std::pair("GICP_OMP", Method::kGicp)}) {
    EXPECT_EQ(implemented_by(load_text(std::string("registration_method: ") + name).method),
              method);
  }
}

TEST(RegistrationConfig, RefusesAnUnknownMethod) {
  EXPECT_THROW(load_text("registration_method: NTD\n"), ConfigError);
}

}  // namespace
}  // namespace lidar_mapping::registration
