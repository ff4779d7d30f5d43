// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/session/session.hpp"

#include "file_content.hpp"
#include "program.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

/// A short drive that was simulated and mapped once for all tests of a program: its bag, and a
/// session of an undisturbed run.
class MappedDrive : public testing::Test {
 protected:
  using Clock = std::chrono::steady_clock;

  static const std::filesystem::path& root() { return made().folder.path(); }
  static std::string bag() { return root() / "drive.bag"; }
  /// The session of the undisturbed run, and the seconds that it took.
  static std::filesystem::path whole() { return root() / "whole"; }
  static double whole_seconds() { return made().seconds; }

  static Words with_bag(Words words) {
    words.insert(words.begin(), bag());
    return words;
  }
  static int run(const std::string& program, const Words& words) {
    return Program(program, words, root() / "log").wait();
  }
  static int map(const Words& words) { return run("map_bag", with_bag(words)); }
  static std::string said() { return content_of(root() / "log"); }
  static bool has_said(const std::string& words) { return said().find(words) != std::string::npos; }

  static std::size_t files_in(const std::filesystem::path& folder) {
    if (!std::filesystem::exists(folder)) return 0;
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                  std::filesystem::directory_iterator()));
  }
  static std::size_t key_frames_in(const std::filesystem::path& folder) {
    return session::Session::open(folder, session::Session::Access::kRead).key_frame_count();
  }
  /// Waits until so many key frames have been written, or the program has ended.
  static void wait_for_key_frames(const Program& program, const std::filesystem::path& folder,
                                  std::size_t count) {
    while (files_in(folder / "key_frames") < count && !program.ends_within(0.001)) {
    }
  }

 private:
  struct Made {
    Made() {
      const auto expect = [this](const std::string& program, const Words& words) {
        Program running(program, words, folder.path() / "log");
        if (running.wait() != 0) throw std::runtime_error(running.output());
      };
      const std::string drive = folder.path() / "drive.bag";
      expect("simulate_drive", {drive, "--lidar", "vlp16", "--duration", "14"});
      const auto begin = Clock::now();
      expect("map_bag",
             {drive, "-o", folder.path() / "whole", "--threads", "2", "--formats", "pcd,ply,png"});
      seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    }
    TemporaryFolder folder;
    double seconds = 0.0;
  };
  static const Made& made() {
    static const Made once;
    return once;
  }
};

}  // namespace lidar_mapping::test
