// SPDX-License-Identifier: BSD-3-Clause
// Odometry of a folder of scans (*.pcd, *.bin or KITTI's folders), written as a TUM file.
//   odometry_of_folder FOLDER TRAJECTORY.tum

#include <cstdio>
#include <exception>
#include <variant>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/pipeline/folder_input.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"

namespace {

using namespace lidar_mapping;

/// Preprocessing and front end, one after the other.
class Odometry {
 public:
  explicit Odometry(const pipeline::FolderInput& input)
      : preprocessor_({}, [&input](const std::string& frame) { return input.T_base(frame); }),
        front_end_({}) {}

  void add(preprocessing::RawScan scan) { track(preprocessor_.process(std::move(scan))); }

  /// At the end of the data: what still waits is worked off as it is.
  Trajectory finish() {
    track(preprocessor_.flush());
    revise(front_end_.finalize());
    return trajectory_;
  }

 private:
  void track(const std::vector<preprocessing::SyncedScan>& scans) {
    for (const preprocessing::SyncedScan& scan : scans) {
      front_end_.set_sensor_pose(scan.T_base_lidar);
      const front_end::FrontEndResult result = front_end_.process(scan.scan);
      revise(result.finalized);
      trajectory_.poses.push_back({result.stamp, result.T_odom_base});
    }
  }

  /// The newest poses were provisional until now: these are the final ones.
  void revise(const std::vector<front_end::FrontEndResult>& final_results) {
    auto pose = trajectory_.poses.end() - static_cast<std::ptrdiff_t>(final_results.size());
    for (const auto& result : final_results) (pose++)->pose = result.T_odom_base;
  }

  preprocessing::Preprocessor preprocessor_;
  front_end::FrontEnd front_end_;
  Trajectory trajectory_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: odometry_of_folder FOLDER TRAJECTORY.tum");
  pipeline::FolderInput input(argv[1]);
  Odometry odometry(input);
  while (const auto datum = input.next()) {
    const auto* scan = std::get_if<pipeline::RecordedScan>(&*datum);
    if (scan != nullptr) odometry.add(scan->decode({}));
  }
  const Trajectory trajectory = odometry.finish();
  write_text_atomically(argv[2], to_tum(trajectory));
  std::printf("%s: %zu poses\n", input.description().c_str(), trajectory.poses.size());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
