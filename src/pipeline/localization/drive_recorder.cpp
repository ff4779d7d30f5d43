// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/drive_recorder.hpp"

namespace lidar_mapping::pipeline {

void DriveRecorder::add_key_frame(const RunKeyFrame& received) {
  pairing_.add(received);
  store_ready();
}

void DriveRecorder::add_place(const localization::LocalizationResult& place) {
  pairing_.add(place);
  store_ready();
}

void DriveRecorder::store_ready() {
  for (const auto& [key_frame, place] : pairing_.take_ready()) {
    extender_->add_key_frame(key_frame, place);
  }
}

void DriveRecorder::withdraw_place() {
  if (pairing_.withdraw_place()) extender_->withdraw_place();
}

}  // namespace lidar_mapping::pipeline
