// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <memory>
#include <set>

#include "lidar_mapping/common/list_file.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/moving_objects/transformed_points.hpp"

#include "marks.hpp"
#include "visibility/observers.hpp"
#include "votes/moving_points.hpp"

namespace lidar_mapping::moving_objects {

namespace {

// Fraction of the points that are isolated, from which on it rains or snows. Chosen: about a
// hundred points of 64 beams, more than the tips of leaves give.
constexpr double kMinRainFraction = 0.002;

}  // namespace

class StaticClouds::Impl {
 public:
  Impl(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::Vector3d& p_base_sensor,
       const MovingObjectsConfig& config, const std::filesystem::path& directory)
      : clouds_(clouds),
        config_(config),
        observers_(clouds, poses, p_base_sensor, config),
        marks_(directory) {}

  /// The moving points, or the static ones, of each key frame.
  std::vector<PointCloudPtr> moving_or_static_clouds(const std::vector<KeyFrameIndex>& indices,
                                                     bool moving) {
    std::vector<PointCloudPtr> clouds = clouds_.clouds(indices, config_.threads);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto position = observers_.position_of(indices[i]);
      if (clouds[i] && position && !marks_.contains(*position)) mark_batch(*position);
    }
    parallel_for(indices.size(), [&](std::size_t i) {
      const auto position = observers_.position_of(indices[i]);
      if (!clouds[i] || !position) return;
      const Marks marks = marks_.get(*position);
      clouds[i] = moving ? marked_points(*clouds[i], marks) : unmarked_points(*clouds[i], marks);
    });
    return clouds;
  }

 private:
  using Position = Observers::Position;

  /// Marks the moving points of the batch to which this key frame belongs.
  void mark_batch(Position position) {
    const Observers::Batch batch = observers_.batch_of(position);
    std::set<Position> needed;
    for (Position i = batch.begin; i < batch.end; ++i) observers_.insert_neighbours(i, needed);
    observers_.keep(needed);
    const std::vector<PointCloudPtr> clouds = clouds_.clouds(batch.indices, config_.threads);
    std::vector<Marks> marks(clouds.size());
    parallel_for(clouds.size(), [&](std::size_t i) {
      if (clouds[i] && observers_.at(batch.begin + i) != nullptr) {
        marks[i] = marks_of(batch.begin + i, *clouds[i]);
      }
    });
    for (std::size_t i = 0; i < marks.size(); ++i) marks_.put(batch.begin + i, marks[i]);
  }

  Marks marks_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = observers_.poses()[position].T_map_base;
    const TransformedPoints points(cloud, T_map_base);
    const std::vector<const ObservingScan*> observers = observers_nearest_first(position);
    std::vector<Layer> layers = observers_.layers(position, points);
    const std::vector<Vote> votes =
        collect_votes(cloud, T_map_base, voted_points(layers), observers, config_);
    for (const std::uint32_t drop :
         raindrops(cloud, T_map_base, isolated_points(points, votes), observers)) {
      layers[drop] = Layer::kIsolated;
    }
    return moving_points(points, votes, layers);
  }

  /// Isolated points that are drops of rain or snow; none if there are few of them, because then
  /// they belong to objects. The votes have to be clearer than usual, because an isolated point has
  /// no neighbours to decide with.
  Marks raindrops(const PointCloud& cloud, const Pose& T_map_base,
                  const std::vector<std::uint32_t>& isolated,
                  const std::vector<const ObservingScan*>& observers) const {
    MovingObjectsConfig strict_config = config_;
    strict_config.min_votes *= 2;
    strict_config.min_fraction = 0.5 * (1.0 + config_.min_fraction);
    const std::vector<Vote> votes =
        collect_votes(cloud, T_map_base, isolated, observers, strict_config);
    Marks found;
    std::copy_if(isolated.begin(), isolated.end(), std::back_inserter(found),
                 [&](std::uint32_t i) { return votes[i] == Vote::kMoving; });
    if (static_cast<double>(found.size()) < kMinRainFraction * static_cast<double>(cloud.size()))
      found.clear();
    return found;
  }

  /// The observers around, nearest first, because these usually decide.
  std::vector<const ObservingScan*> observers_nearest_first(Position position) const {
    const auto [begin, end] = observers_.neighbours_of(position);
    std::vector<const ObservingScan*> nearest;
    for (Position step = 1; step <= static_cast<Position>(config_.neighbours); ++step) {
      // Positions below 0 wrap, and lie behind the end.
      for (const Position other : {position - step, position + step}) {
        if (other < begin || other >= end) continue;
        const ObservingScan* observer = observers_.at(other);
        if (observer != nullptr) nearest.push_back(observer);
      }
    }
    return nearest;
  }

  void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) const {
    parallel_chunks(count, 1, config_.threads, [&](std::size_t i, std::size_t) { body(i); });
  }

  CloudSource& clouds_;
  const MovingObjectsConfig config_;
  Observers observers_;
  ListFile<Position, Marks::value_type> marks_;  ///< Moving points.
};

StaticClouds::StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
                           const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config,
                           const std::filesystem::path& directory)
    : impl_(std::make_unique<Impl>(clouds, poses, p_base_sensor, config, directory)) {}
StaticClouds::~StaticClouds() = default;

PointCloudPtr StaticClouds::cloud(KeyFrameIndex index) {
  return impl_->moving_or_static_clouds({index}, false).front();
}
std::vector<PointCloudPtr> StaticClouds::clouds(const std::vector<KeyFrameIndex>& indices,
                                                int /*threads*/) {
  return impl_->moving_or_static_clouds(indices, false);
}
PointCloudPtr StaticClouds::removed(KeyFrameIndex index) {
  return impl_->moving_or_static_clouds({index}, true).front();
}

}  // namespace lidar_mapping::moving_objects
