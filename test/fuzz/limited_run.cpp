// SPDX-License-Identifier: BSD-3-Clause
#include "limited_run.hpp"

#include <csignal>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "child_end.hpp"
#include "file_content.hpp"

namespace lidar_mapping::test {

namespace {

void limit(__rlimit_resource resource, rlim_t value) {
  const rlimit limits{value, value};
  setrlimit(resource, &limits);
}

[[noreturn]] void become(const std::string& program, const std::vector<std::string>& words,
                         const std::string& output, unsigned seconds) {
  limit(RLIMIT_CPU, seconds);
  limit(RLIMIT_CORE, 0);
  // The sanitizer reserves terabytes of addresses, so it limits the memory itself.
  setenv("LD_PRELOAD", LIDAR_MAPPING_PRELOADED, 1);
  setenv("ASAN_OPTIONS",
         "detect_leaks=0:detect_odr_violation=0:allocator_may_return_null=1:"
         "max_allocation_size_mb=8000:hard_rss_limit_mb=8000",
         1);
  const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(file, STDOUT_FILENO);
  dup2(file, STDERR_FILENO);
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

}  // namespace

RunResult run_limited(const std::filesystem::path& program, const std::vector<std::string>& words,
                      const std::filesystem::path& output, unsigned seconds) {
  constexpr int kClockPerProcessor = 10;
  const pid_t pid = fork();
  if (pid == 0) become(program.string(), words, output.string(), seconds);
  RunResult result;
  if (!test::ends_within(pid, kClockPerProcessor * seconds)) {
    result.hung = true;
    kill(pid, SIGKILL);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
  result.hung = result.hung || result.signal == SIGXCPU || result.signal == SIGKILL;
  result.output = content_of(output);
  return result;
}

}  // namespace lidar_mapping::test
