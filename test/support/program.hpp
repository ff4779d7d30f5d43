// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "child_end.hpp"
#include "file_content.hpp"

namespace lidar_mapping::test {

using Words = std::vector<std::string>;

/// A program of this package beside the test.
class Program {
 public:
  Program(const std::string& name, const Words& words, const std::filesystem::path& output)
      : output_(output) {
    const std::string path = std::string(LIDAR_MAPPING_PROGRAMS) + "/" + name;
    pid_ = fork();
    if (pid_ == 0) become(path, words);
  }
  ~Program() {
    if (pid_ > 0) kill(SIGKILL), wait();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void kill(int signal) const { ::kill(pid_, signal); }
  /// Its status, or 128 and the signal that ended it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  /// Waits for its end, at most `seconds`; says whether it has ended.
  bool ends_within(double seconds) const { return test::ends_within(pid_, seconds); }
  bool is_running() const { return !ends_within(0.0); }
  std::string output() const { return content_of(output_); }

 private:
  [[noreturn]] void become(const std::string& path, const Words& words) const {
    const int file = open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    std::vector<char*> argv = {const_cast<char*>(path.c_str())};
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    execv(path.c_str(), argv.data());
    _exit(127);
  }

  std::filesystem::path output_;
  pid_t pid_ = -1;
};

}  // namespace lidar_mapping::test
