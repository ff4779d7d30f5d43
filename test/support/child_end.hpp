// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <ctime>
#include <system_error>

#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace lidar_mapping::test {

/// Waits until a child of this process has ended, at most `seconds`. Says whether it has; its
/// status is still there for waitpid().
inline bool ends_within(pid_t child, double seconds) {
  // A descriptor that can be read when the process has ended (Linux 5.3); glibc wraps it
  // since 2.36.
  const auto descriptor = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), "pidfd_open");
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end =
      Clock::now() + std::chrono::nanoseconds(std::llround(1e9 * seconds));
  pollfd event{descriptor, POLLIN, 0};
  int result = -1;
  do {
    const auto left = std::max(Clock::duration::zero(), end - Clock::now());
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec timeout{whole.count(), std::chrono::nanoseconds(left - whole).count()};
    result = ::ppoll(&event, 1, &timeout, nullptr);
  } while (result < 0 && errno == EINTR);
  ::close(descriptor);
  return result > 0;
}

}  // namespace lidar_mapping::test
