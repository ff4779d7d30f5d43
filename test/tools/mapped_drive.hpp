// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "lidar_mapping/session/session.hpp"

#include "commands.hpp"

namespace lidar_mapping::test {

/// A short drive that was simulated and mapped once for all tests of a program: its bag, and a
/// session of an undisturbed run.
class MappedDrive : public Commands {
 protected:
  using Clock = std::chrono::steady_clock;

  MappedDrive() { whole_seconds(); }

  static std::string bag() { return root() / "drive.bag"; }
  /// The session of the undisturbed run, and the seconds that it took.
  static std::filesystem::path whole() { return root() / "whole"; }
  static double whole_seconds() {
    static const double seconds = made_in();
    return seconds;
  }

  static Words with_bag(const Words& words) { return joined({bag()}, words); }
  static Ending map(const Words& words) { return run("map_bag", with_bag(words)); }

  static std::size_t files_in(const std::filesystem::path& folder) {
    if (!std::filesystem::exists(folder)) return 0;
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                  std::filesystem::directory_iterator()));
  }
  static session::Session opened(const std::filesystem::path& folder) {
    return session::Session::open(folder, session::Session::Access::kRead);
  }
  static std::size_t key_frames_in(const std::filesystem::path& folder) {
    return opened(folder).key_frame_count();
  }
  /// Waits until so many key frames have been written, or the program has ended.
  static void wait_for_key_frames(const Program& program, const std::filesystem::path& folder,
                                  std::size_t count) {
    while (files_in(folder / "key_frames") < count && !program.ends_within(0.001)) {
    }
  }

 private:
  /// Simulates and maps the drive; the seconds that mapping took.
  static double made_in() {
    const auto expect = [](const Ending& ending) {
      if (ending.status != 0) throw std::runtime_error(ending.said);
    };
    expect(run("simulate_drive", {bag(), "--lidar", "vlp16", "--duration", "14"}));
    const auto begin = Clock::now();
    expect(map({"-o", whole(), "--threads", "2", "--formats", "pcd,ply,png"}));
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }
};

}  // namespace lidar_mapping::test
