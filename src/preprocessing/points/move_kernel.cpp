// SPDX-License-Identifier: BSD-3-Clause
#include "points/move_kernel.hpp"

#include "points/move_kernel_body.hpp"

namespace lidar_mapping::preprocessing {

MoveKernel portable_move_kernel() { return move_points; }

MoveKernel move_kernel() {
  static const MoveKernel chosen = avx512_move_kernel() != nullptr ? avx512_move_kernel()
                                   : avx2_move_kernel() != nullptr ? avx2_move_kernel()
                                                                   : portable_move_kernel();
  return chosen;
}

}  // namespace lidar_mapping::preprocessing
