// SPDX-License-Identifier: BSD-3-Clause
#include "resume_point.hpp"

#include <string>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/pipeline/pipeline.hpp"

namespace lidar_mapping::pipeline {

namespace {

// m and rad (0.5 degrees), at the end of the section. Chosen: another recording differs by more,
// the same one by millimetres.
constexpr double kTolerance = 0.2;
constexpr double kAngleTolerance = 0.0087;

InputError wrong_recording(const KeyFrame& key_frame) {
  return InputError("the recording has no scan at key frame " + std::to_string(key_frame.index) +
                    " of the session (stamp " + std::to_string(key_frame.stamp) +
                    " ns); name the recording that the session was made of");
}

}  // namespace

std::optional<ResumePoint> resume_point_of(const session::Session& session, double path_length,
                                           bool whole) {
  const std::vector<KeyFrame> key_frames = session.key_frames();
  if (key_frames.empty()) return std::nullopt;
  double travelled = 0.0;
  std::size_t first = key_frames.size() - 1;
  while (first > 0 && (whole || travelled < path_length)) {
    const Eigen::Vector3d& p = key_frames[first].T_odom_base.translation;
    --first;
    travelled += (p - key_frames[first].T_odom_base.translation).norm();
  }
  return ResumePoint{key_frames[first], key_frames.back()};
}

bool ResumedOdometry::accepts(front_end::FrontEndResult& result) {
  if (!has_begun_ && result.stamp >= point_.first.stamp) {
    if (result.stamp != point_.first.stamp) throw wrong_recording(point_.first);
    T_first_ = result.T_odom_base;
    has_begun_ = true;
  }
  if (!is_aligned_ && result.key_frame) newest_ = result.key_frame;
  if (!is_aligned_) {
    if (result.stamp >= point_.last.stamp) align_to_session(result);
    return false;
  }
  result.T_odom_base = T_session_front_end_ * result.T_odom_base;
  if (!result.key_frame) return true;
  KeyFrame& key_frame = *result.key_frame;
  key_frame.index += index_offset_;
  key_frame.segment += segment_offset_;
  key_frame.T_odom_base = result.T_odom_base;
  return true;
}

void ResumedOdometry::align_to_session(const front_end::FrontEndResult& result) {
  if (result.stamp != point_.last.stamp) throw wrong_recording(point_.last);
  const Pose expected = point_.first.T_odom_base.inverse() * point_.last.T_odom_base;
  const Pose error = expected.inverse() * T_first_.inverse() * result.T_odom_base;
  if (!newest_ || error.translation.norm() > kTolerance ||
      rotation_angle(error.rotation) > kAngleTolerance) {
    throw ResumeFailure("the last section of the session has another result than before");
  }
  T_session_front_end_ = point_.last.T_odom_base * result.T_odom_base.inverse();
  // Unsigned differences may wrap, and the addition wraps back.
  index_offset_ = point_.last.index - newest_->index;
  segment_offset_ = point_.last.segment - newest_->segment;
  is_aligned_ = true;
}

}  // namespace lidar_mapping::pipeline
