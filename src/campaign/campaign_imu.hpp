// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

namespace lidar_mapping::campaign {

/// The scans of a drive with its IMU's samples, as preprocessing gives them.
class ImuFeed {
 public:
  explicit ImuFeed(const simulation::Drive& drive);

  /// The scan `index` with its samples; nothing where preprocessing drops it. In order.
  std::optional<preprocessing::SyncedScan> next(std::size_t index);

 private:
  const simulation::Drive& drive_;
  std::vector<ImuSample> samples_;
  std::size_t added_ = 0;
  preprocessing::Preprocessor preprocessor_;
};

}  // namespace lidar_mapping::campaign
