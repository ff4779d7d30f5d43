// SPDX-License-Identifier: BSD-3-Clause
// What faults of GNSS do to the final error of a simulated drive: a table of errors, and of their
// ratios to that of the clean receiver. Odometry and loops are computed once and kept in a session.

#include <cstdio>
#include <filesystem>
#include <map>

#include <CLI/CLI.hpp>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/session/session.hpp"

#include "../pipeline/gnss_drive.hpp"

namespace {

using namespace lidar_mapping;

constexpr std::size_t kSolveEvery = 100;  // key frames

/// The clouds of the session's key frames.
class SessionClouds : public CloudSource {
 public:
  explicit SessionClouds(const session::Session& session) : session_(session) {}
  PointCloudPtr cloud(KeyFrameIndex index) override { return session_.clouds().cloud(index); }

 private:
  const session::Session& session_;
};

front_end::MotionPrior prior_of(const preprocessing::SyncedScan& synced) {
  front_end::MotionPrior prior;
  if (synced.imu && synced.imu->has_angular_velocity) {
    prior.angular_velocity = synced.imu->angular_velocity;
  }
  if (synced.velocity) {
    prior.linear_velocity = synced.velocity->linear;
    prior.velocity_turning = synced.velocity->angular;
  }
  return prior;
}

/// Drives without GNSS; loops are searched about poses that are solved again and again.
void record(const simulation::Drive& drive, session::Session& session) {
  front_end::FrontEnd front_end{front_end::FrontEndConfig{}};
  front_end.set_sensor_pose(drive.mounting().T_base_lidar);
  SessionClouds clouds(session);
  loop_closing::LoopCloser closer(loop_closing::LoopClosingConfig{}, clouds);
  closer.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  back_end::BackEnd back_end{back_end::BackEndConfig{}};
  std::map<Stamp, front_end::MotionPrior> priors;
  for (const auto& synced : test::preprocessed_scans(drive, std::nullopt, {})) {
    priors[synced.scan.stamp] = prior_of(synced);
  }
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    simulation::SimulatedScan taken = drive.scan(i);
    const Scan scan{taken.stamp, std::move(taken.cloud)};
    const auto result = front_end.process(scan, priors[scan.stamp]);
    if (!result.key_frame) continue;  // none is held back where a drive begins at rest
    session.add_key_frame(*result.key_frame);
    back_end.add_key_frame(*result.key_frame);
    for (const Loop& loop : closer.process(*result.key_frame).loops) {
      session.add_loop(loop);
      back_end.add_loop(loop);
    }
    if (session.key_frame_count() % kSolveEvery != 0) continue;
    back_end.apply(*back_end::solve(*back_end.problem()));
    closer.update_poses(back_end.poses());
  }
}

test::DriveOdometry odometry_in(const std::string& directory, const simulation::Drive& drive) {
  if (!std::filesystem::exists(directory)) {
    std::filesystem::create_directories(directory);
    auto session = session::Session::create_in(directory);
    record(drive, session);
  }
  const auto session = session::Session::open(directory, session::Session::Access::kRead);
  return {session.key_frames(), session.loops()};
}

void print_table(const simulation::Drive& drive, const test::DriveOdometry& odometry) {
  const test::Receiver rtk = test::receiver_of(drive);
  const test::Receiver single = test::noisy_receiver(drive, 1.0);
  const double clean_rtk = test::final_error(drive, odometry, rtk);
  const double clean_single = test::final_error(drive, odometry, single);
  std::printf("%zu key frames, %zu loops\n", odometry.key_frames.size(), odometry.loops.size());
  const auto line = [](const std::string& name, double error, double clean) {
    std::printf("%-36s %7.3f m  %5.2f\n", name.c_str(), error, error / clean);
  };
  line("without GNSS", test::final_error(drive, odometry, std::nullopt), clean_rtk);
  line("RTK, 2 cm", clean_rtk, clean_rtk);
  line("single, 1 m", clean_single, clean_single);
  for (const test::GnssFault& fault : test::gnss_faults(drive, rtk, single)) {
    line(fault.name, test::final_error(drive, odometry, fault.faulty),
         fault.clean == &rtk ? clean_rtk : clean_single);
  }
}

}  // namespace

int main(int argc, char** argv) {
  simulation::DriveOptions options;
  options.lidar = "vlp16";
  std::string directory;
  CLI::App app{"Final errors of a simulated drive with faulty GNSS"};
  app.add_option("session", directory, "odometry and loops; made if it is not there")->required();
  app.add_option("--drive", options.drive, "world and way")->capture_default_str();
  app.add_option("--lidar", options.lidar, "sensor")->capture_default_str();
  app.add_option("--seed", options.seed, "seed of the drive")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const simulation::Drive drive(options);
    print_table(drive, odometry_in(directory, drive));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gnss_faults: %s\n", error.what());
    return 1;
  }
}
