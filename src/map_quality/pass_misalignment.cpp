// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "lidar_mapping/common/path_length.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "pass_registration.hpp"

namespace lidar_mapping::map_quality {

namespace {

// m, length of a section of the later pass. Chosen: shorter ones have too few walls, and over
// longer ones the misalignment changes.
constexpr double kSectionLength = 10.0;
// m, largest distance between the passes. Chosen: the width of a street, so that both lanes are
// compared.
constexpr double kMaxPassDistance = 10.0;
// m. Chosen: larger height differences belong to another storey, which even in car parks are more
// than 2 m high.
constexpr double kMaxHeightDifference = 2.0;
// m, least path length between the passes. Chosen: a turning vehicle returns to a place after 20 m
// to 30 m, which says nothing about the map, while a round of a block is longer.
constexpr double kMinPathBetweenPasses = 40.0;
// Points per pass and section. Chosen: bounds the time, while cells of 1 m still have their points.
constexpr std::size_t kMaxPointsPerPass = 80'000;
// Key frames of the earlier passes in a section. Chosen: one alone may be a vehicle that only
// touches it.
constexpr std::size_t kMinEarlierKeyFrames = 2;

/// Sections of the path that the vehicle has passed before, and the points around them.
class RevisitedSections {
 public:
  RevisitedSections(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config)
      : poses_(poses.poses),
        clouds_(clouds),
        config_(config),
        path_lengths_(travelled_distances(poses)) {}

  std::vector<PassMisalignment> misalignments() const {
    std::vector<PassMisalignment> result;
    for (const Section& section : sections()) {
      const ObservedPoints earlier = points_of(section.earlier, section);
      const ObservedPoints later = points_of(section.later, section);
      const PassShift found = register_passes(earlier, later, config_.p_base_sensor.has_value());
      if (found.is_known()) result.push_back(misalignment_of(section, found));
    }
    return result;
  }

  PassPoints points_at(KeyFrameIndex index) const {
    for (const Section& section : sections()) {
      if (poses_[section.middle].index != index) continue;
      return {in_vehicle_axes(points_of(section.earlier, section), section),
              in_vehicle_axes(points_of(section.later, section), section)};
    }
    return {};
  }

 private:
  /// Key frames of the later pass, and the earlier ones near them, as positions in poses_.
  struct Section {
    std::size_t middle;
    std::vector<std::size_t> earlier;
    std::vector<std::size_t> later;
  };

  std::vector<Section> sections() const {
    std::vector<Section> sections;
    for (std::size_t begin = 0; begin < poses_.size();) {
      std::size_t end = begin + 1;
      while (end < poses_.size() && path_lengths_[end] - path_lengths_[begin] < kSectionLength)
        ++end;
      Section section{(begin + end) / 2, earlier_key_frames(begin, end), {}};
      for (std::size_t i = begin; i < end; ++i) section.later.push_back(i);
      if (section.earlier.size() >= kMinEarlierKeyFrames) sections.push_back(section);
      begin = end;
    }
    return sections;
  }

  const Eigen::Vector3d& position(std::size_t i) const { return poses_[i].T_map_base.translation; }

  std::vector<std::size_t> earlier_key_frames(std::size_t begin, std::size_t end) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0;
         i < begin && path_lengths_[begin] - path_lengths_[i] > kMinPathBetweenPasses; ++i) {
      for (std::size_t j = begin; j < end; ++j) {
        const Eigen::Vector3d between = position(i) - position(j);
        if (between.norm() > kMaxPassDistance || std::abs(between.z()) > kMaxHeightDifference)
          continue;
        found.push_back(i);
        break;
      }
    }
    return found;
  }

  /// Points relative to the middle of the section.
  ObservedPoints points_of(const std::vector<std::size_t>& members, const Section& section) const {
    const Eigen::Vector3d centre = position(section.middle);
    ObservedPoints points;
    for (const std::size_t member : members) {
      const PointCloudPtr cloud = clouds_.cloud(poses_[member].index);
      if (!cloud) continue;
      const Pose& T_map_base = poses_[member].T_map_base;
      const std::size_t points_per_member = kMaxPointsPerPass / members.size() + 1;
      const std::size_t step = cloud->size() / points_per_member + 1;
      for (std::size_t i = 0; i < cloud->size(); i += step) {
        const Eigen::Vector3d p_base = cloud->points[i].position().cast<double>();
        if (!(p_base.norm() <= config_.max_range)) continue;  // also what is no number
        points.push_back({T_map_base * p_base - centre, T_map_base.rotation * beam_to(p_base)});
      }
    }
    return points;
  }

  Eigen::Vector3d beam_to(const Eigen::Vector3d& p_base) const {
    if (!config_.p_base_sensor) return Eigen::Vector3d::Zero();
    return p_base - *config_.p_base_sensor;
  }

  Eigen::Quaterniond R_vehicle_map(const Section& section) const {
    return exp_so3({0.0, 0.0, -yaw_of(poses_[section.middle].T_map_base.rotation)});
  }

  PassMisalignment misalignment_of(const Section& section, const PassShift& found) const {
    const Eigen::Vector3d t = R_vehicle_map(section) * Eigen::Vector3d(found.shift.head<3>());
    return {poses_[section.middle].index,
            position(section.middle),
            t.x(),
            t.y(),
            t.z(),
            found.shift[3],
            found.planes,
            found.residual};
  }

  std::vector<Eigen::Vector3f> in_vehicle_axes(const ObservedPoints& points,
                                               const Section& section) const {
    const Eigen::Quaterniond rotation = R_vehicle_map(section);
    std::vector<Eigen::Vector3f> rotated;
    for (const ObservedPoint& point : points) {
      rotated.push_back((rotation * point.position).cast<float>());
    }
    return rotated;
  }

  const std::vector<KeyFramePose>& poses_;
  CloudSource& clouds_;
  const QualityConfig config_;
  std::vector<double> path_lengths_;  ///< Path length from the start to each key frame, m.
};

}  // namespace

std::vector<PassMisalignment> pass_misalignments(const KeyFramePoses& poses, CloudSource& clouds,
                                                 const QualityConfig& config) {
  return RevisitedSections(poses, clouds, config).misalignments();
}

PassPoints pass_points(const KeyFramePoses& poses, CloudSource& clouds, const QualityConfig& config,
                       const PassMisalignment& misalignment) {
  return RevisitedSections(poses, clouds, config).points_at(misalignment.key_frame);
}

}  // namespace lidar_mapping::map_quality
