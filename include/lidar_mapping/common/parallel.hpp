// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace lidar_mapping {

/// Calls body(begin, end) for consecutive chunks of `grain` indices of [0, count), on at most
/// `threads` threads (1 runs in the caller's thread, 0 takes all cores). The chunks do not depend
/// on the number of threads: results that are written per chunk and reduced in chunk order have the
/// same bits for any of them.
void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace lidar_mapping
