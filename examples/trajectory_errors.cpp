// SPDX-License-Identifier: BSD-3-Clause
// Errors of an estimated trajectory against the true one (files in TUM's or KITTI's format), after
// a rigid alignment.
//   trajectory_errors TRUTH ESTIMATE

#include "lidar_mapping/evaluation/trajectory_errors.hpp"

#include <cstdio>
#include <exception>

#include "lidar_mapping/common/errors.hpp"

using namespace lidar_mapping;

namespace {

constexpr double kDeltaM = 10.0;  // path length over which the relative error is taken, m

void print(const char* name, const evaluation::PoseErrors& errors) {
  std::printf("%s: translation RMSE %.6f m, max %.6f m; rotation RMSE %.6f deg\n", name,
              errors.translation_m.rmse, errors.translation_m.max, errors.rotation_deg.rmse);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: trajectory_errors TRUTH ESTIMATE");
  auto pairs = evaluation::associate(read_trajectory(argv[1]), read_trajectory(argv[2]));
  pairs = evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));

  std::printf("%zu poses, %.1f m\n", pairs.size(), evaluation::travelled_distances(pairs).back());
  print("APE", evaluation::absolute_pose_error(pairs));
  print("RPE over 10 m", evaluation::relative_pose_error(pairs, kDeltaM));
  const auto lengths = evaluation::usual_segment_lengths(pairs);
  const auto kitti = evaluation::kitti_errors(pairs, lengths, 1);
  std::printf("KITTI: %.6f %%, %.6f deg/100 m over %zu segments\n", kitti.translation_percent,
              kitti.rotation_deg_per_100m, kitti.segments);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
