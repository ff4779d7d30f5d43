// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// CHOLMOD's OpenMP threads wait actively between the parts of a factorisation. This costs processor
// time and gains little for the sparse factors of a drive. While an object of this class exists,
// OpenMP regions of the calling thread run on that thread alone. The symbols are weak, because
// CHOLMOD may be built without OpenMP.

extern "C" {
__attribute__((weak)) int omp_get_max_active_levels();
__attribute__((weak)) void omp_set_max_active_levels(int levels);
}

namespace lidar_mapping::pose_graph {

class SingleThreadedOpenMp {
 public:
  SingleThreadedOpenMp() {
    if (omp_set_max_active_levels == nullptr || omp_get_max_active_levels == nullptr) return;
    levels_ = omp_get_max_active_levels();
    omp_set_max_active_levels(0);
  }
  ~SingleThreadedOpenMp() {
    if (levels_ >= 0) omp_set_max_active_levels(levels_);
  }
  SingleThreadedOpenMp(const SingleThreadedOpenMp&) = delete;
  SingleThreadedOpenMp& operator=(const SingleThreadedOpenMp&) = delete;

 private:
  int levels_ = -1;  ///< levels before; negative: nothing to restore
};

}  // namespace lidar_mapping::pose_graph
