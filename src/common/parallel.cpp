// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/parallel.hpp"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "happens_before.hpp"

namespace lidar_mapping {

void parallel_chunks(std::size_t count, std::size_t grain, int threads,
                     const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t chunks = (count + grain - 1) / grain;
  const auto run_chunk = [&](std::size_t chunk) {
    body(chunk * grain, std::min(count, (chunk + 1) * grain));
  };
  if (threads == 1 || chunks <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    return;
  }
  // TBB complains aloud when an arena asks for more threads than there are cores.
  const int cores = tbb::this_task_arena::max_concurrency();
  tbb::task_arena arena(threads > 0 ? std::min(threads, cores) : tbb::task_arena::automatic);
  // TBB keeps this order; two chunks have none.
  HappensBefore begin, end;
  begin.release();
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
      begin.acquire();
      run_chunk(chunk);
      end.release();
    });
  });
  end.acquire();
}

}  // namespace lidar_mapping
