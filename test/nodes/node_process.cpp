// SPDX-License-Identifier: BSD-3-Clause
#include "node_process.hpp"

#include <csignal>

#include <fcntl.h>
#include <ros/master.h>
#include <ros/param.h>
#include <sys/wait.h>
#include <unistd.h>

#include "child_end.hpp"
#include "file_content.hpp"

namespace lidar_mapping::test {

namespace {

/// The child of a process with threads may call little but this: no memory, no C++ library.
[[noreturn]] void become(char* const* words, const char* output_file) {
  const int file = open(output_file, O_WRONLY | O_APPEND | O_CREAT, 0600);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  execvp(words[0], words);
  _exit(127);
}

}  // namespace

NodeProcess::NodeProcess(const std::string& program, const std::vector<std::string>& arguments)
    : output_file_((folder_.path() / "output").string()) {
  // Programs of this package by their name, others by their path.
  const std::string path = program.find('/') == std::string::npos
                               ? std::string(LIDAR_MAPPING_PROGRAMS) + "/" + program
                               : program;
  // What an earlier node of this name was told must not reach this one.
  if (ros::param::has("/" + program)) ros::param::del("/" + program);
  std::vector<char*> words = {const_cast<char*>(path.c_str())};
  for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) become(words.data(), output_file_.c_str());
}

NodeProcess::~NodeProcess() { stop(); }

bool NodeProcess::is_running() { return wait(0.0) == -1; }

void NodeProcess::stop() { end(SIGINT); }

void NodeProcess::kill() { end(SIGKILL); }

void NodeProcess::end(int signal) {
  if (!is_running()) return;
  ::kill(pid_, signal);
  if (wait() != -1 || !is_running()) return;
  ::kill(pid_, SIGKILL);
  wait();
}

int NodeProcess::wait(double seconds) {
  if (pid_ < 0) return status_;
  if (!ends_within(pid_, seconds)) return -1;
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

std::string NodeProcess::output() const { return content_of(output_file_); }

std::size_t NodeProcess::count(const std::string& text) const {
  const std::string all = output();
  std::size_t found = 0;
  for (auto at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++found;
  return found;
}

}  // namespace lidar_mapping::test
