// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/observing_scan.hpp"

#include <algorithm>
#include <array>

namespace lidar_mapping::moving_objects {

namespace {

// Points that are processed together. Chosen: their arrays (7 x 4 KB) fit into the first cache.
constexpr std::size_t kChunk = 1024;
constexpr std::size_t kLanes = 16;  // floats in a register of 512 bits, the widest one
// Observers. Chosen: more often costs more time than it saves.
constexpr std::size_t kFinalizeInterval = 4;

/// An observer relative to the key frame whose points are voted on.
struct ObserverView {
  const RangeImage* image;
  Viewpoint view;
};

/// Points that are voted on, with the observations of each. The arrays are longer than the number
/// of points, so that kernels can process whole vectors.
struct PointChunk {
  std::array<float, kChunk> x{}, y{}, z{};  ///< Coordinates in base_link, m.
  std::array<std::uint32_t, kChunk> points{};
  std::array<int, kChunk> remaining{};  ///< Observers in range that were not evaluated yet.
  std::array<int, kChunk> through{};
  std::array<int, kChunk> hits{};
  std::size_t size = 0;

  std::size_t padded_size() const { return (size + kLanes - 1) / kLanes * kLanes; }
  PointArrays arrays() const { return {x.data(), y.data(), z.data()}; }

  /// Starts with the points of a cloud with these indices.
  void fill(const PointCloud& cloud, const std::uint32_t* numbers, std::size_t count) {
    for (std::array<int, kChunk>* counts : {&remaining, &through, &hits}) counts->fill(0);
    for (std::size_t i = 0; i < count; ++i) {
      const Point& point = cloud.points[numbers[i]];
      points[i] = numbers[i];
      x[i] = point.x;
      y[i] = point.y;
      z[i] = point.z;
    }
    size = count;
  }

  void copy_point(std::size_t from, std::size_t to) {
    for (std::array<float, kChunk>* values : {&x, &y, &z}) (*values)[to] = (*values)[from];
    for (std::array<int, kChunk>* counts : {&remaining, &through, &hits})
      (*counts)[to] = (*counts)[from];
    points[to] = points[from];
  }
};

class VoteCollector {
 public:
  VoteCollector(std::vector<ObserverView> views, const MovingObjectsConfig& config)
      : views_(std::move(views)), required_(views_.size() + 1) {
    int required = config.min_votes;
    for (std::size_t votes = 0; votes < required_.size(); ++votes) {
      while (required < config.min_fraction * static_cast<double>(votes)) ++required;
      required_[votes] = required;
    }
  }

  /// Votes on all of these points.
  void collect(PointChunk& chunk, std::vector<Vote>& votes) {
    const std::size_t count = chunk.padded_size();
    observers_in_range_.clear();
    for (const ObserverView& observer : views_) {
      const int in_range = visibility_kernels().count_in_range(observer.view, chunk.arrays(), count,
                                                               chunk.remaining.data());
      if (in_range > 0) observers_in_range_.push_back(&observer);
    }
    for (std::size_t i = 0; i < observers_in_range_.size(); ++i) {
      if (i % kFinalizeInterval == 0) finalize_decided(chunk, votes);
      if (chunk.size == 0) return;
      evaluate(*observers_in_range_[i], chunk);
    }
    finalize_decided(chunk, votes);
  }

 private:
  void evaluate(const ObserverView& observer, PointChunk& chunk) {
    const std::size_t count = chunk.padded_size();
    const ProjectedPixels targets = {pixels_.data(), nearest_.data(), farthest_.data()};
    visibility_kernels().project_into_view(observer.view, chunk.arrays(), count, targets,
                                           chunk.remaining.data());
    observer.image->classify(targets, count, {chunk.through.data(), chunk.hits.data()},
                             ambiguous_.data());
  }

  /// Stores the votes and removes the points whose vote cannot change any more. Written without
  /// branches, which would be mispredicted: a preliminary vote is written for the other points,
  /// too, and overwritten later.
  void finalize_decided(PointChunk& chunk, std::vector<Vote>& votes) const {
    std::size_t undecided = 0;
    for (std::size_t i = 0; i < chunk.size; ++i) {
      const int remaining = chunk.remaining[i];
      const int through = chunk.through[i];
      const int hits = chunk.hits[i];
      const int required = required_[remaining + through + hits];
      votes[chunk.points[i]] = vote_if_rest_static(through, hits, required);
      chunk.copy_point(i, undecided);
      undecided += is_decided(remaining, through, hits, required) ? 0 : 1;
    }
    chunk.size = undecided;
  }

  /// Whether the vote is the same whatever the remaining observers report.
  static bool is_decided(int remaining, int through, int hits, int required) {
    const int is_static = (hits > 0 ? 1 : 0) & (through + remaining < required ? 1 : 0);
    return ((remaining == 0 ? 1 : 0) | is_static | (through >= required ? 1 : 0)) != 0;
  }

  /// The vote if all remaining observers report that the point is static.
  static Vote vote_if_rest_static(int through, int hits, int required) {
    const Vote other = through + hits == 0 ? Vote::kUnseen : Vote::kStatic;
    return through >= required ? Vote::kMoving : other;
  }

  const std::vector<ObserverView> views_;
  std::vector<int> required_;  ///< Least number of votes for moving, by the number of all votes.
  std::vector<const ObserverView*> observers_in_range_;
  /// Results of one observer.
  std::array<int, kChunk> pixels_{}, nearest_{}, farthest_{}, ambiguous_{};
};

Viewpoint view_of(const ObservingScan& observer, const Pose& T_map_base, double max_range) {
  const Pose T_sensor_base = observer.T_sensor_map * T_map_base;
  Viewpoint view{};
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(view.R_sensor_points) =
      T_sensor_base.rotation_matrix().cast<float>();
  Eigen::Map<Eigen::Vector3f>(view.p_points_sensor) =
      T_sensor_base.inverse().translation.cast<float>();
  view.squared_max_range = static_cast<float>(max_range * max_range);
  view.first_row = observer.image.first_row();
  view.rows = observer.image.rows();
  return view;
}

std::vector<ObserverView> views_of(const std::vector<const ObservingScan*>& observers,
                                   const Pose& T_map_base, double max_range) {
  std::vector<ObserverView> views;
  for (const ObservingScan* observer : observers)
    views.push_back({&observer->image, view_of(*observer, T_map_base, max_range)});
  return views;
}

}  // namespace

std::vector<Vote> collect_votes(const PointCloud& cloud, const Pose& T_map_base,
                                const std::vector<std::uint32_t>& indices,
                                const std::vector<const ObservingScan*>& observers,
                                const MovingObjectsConfig& config) {
  std::vector<Vote> votes(cloud.size(), Vote::kUnseen);
  VoteCollector collector(views_of(observers, T_map_base, config.max_range), config);
  PointChunk chunk;
  for (std::size_t i = 0; i < indices.size(); i += kChunk) {
    chunk.fill(cloud, indices.data() + i, std::min(kChunk, indices.size() - i));
    collector.collect(chunk, votes);
  }
  return votes;
}

}  // namespace lidar_mapping::moving_objects
