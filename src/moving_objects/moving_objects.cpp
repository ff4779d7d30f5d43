// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <memory>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/moving_objects/transformed_points.hpp"

#include "mark_file.hpp"
#include "moving_points.hpp"
#include "observing_scan.hpp"

namespace lidar_mapping::moving_objects {

namespace {

// Key frames that are processed together, one per thread. Chosen: more need more memory, and few
// processors have more cores.
constexpr std::size_t kBatchSize = 16;
// Neighbours on each side whose points give the near ground. Chosen: 20 key frames cover the
// surroundings of one, and farther ones see its ground from the other side of a crest.
constexpr int kGroundNeighbours = 10;
// Every n-th of the further ones gives the wide ground. Chosen: consecutive ones see much the same.
constexpr int kGroundStep = 3;
// Fraction of the points that are isolated, from which on it rains or snows. Chosen: about a
// hundred points of 64 beams, more than the tips of leaves give.
constexpr double kMinRainFraction = 0.002;

/// Points on the ground or at the base of an object need no votes.
std::vector<std::uint32_t> voted_points(const std::vector<Layer>& layers) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(layers.size());
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i] >= Layer::kBody) numbers.push_back(static_cast<std::uint32_t>(i));
  }
  return numbers;
}

}  // namespace

class StaticClouds::Impl {
 public:
  Impl(CloudSource& clouds, const KeyFramePoses& poses, const Eigen::Vector3d& p_base_sensor,
       const MovingObjectsConfig& config, const std::filesystem::path& directory)
      : clouds_(clouds),
        poses_(poses.poses),
        p_base_sensor_(p_base_sensor),
        config_(config),
        marks_(directory) {
    for (std::size_t i = 0; i < poses_.size(); ++i) positions_[poses_[i].index] = i;
  }

  /// The moving points, or the static ones, of each key frame.
  std::vector<PointCloudPtr> moving_or_static_clouds(const std::vector<KeyFrameIndex>& indices,
                                                     bool moving) {
    std::vector<PointCloudPtr> clouds = clouds_.clouds(indices, config_.threads);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto position = positions_.find(indices[i]);
      if (!clouds[i] || position == positions_.end()) continue;
      if (!marks_.contains(position->second)) mark_batch(position->second);
    }
    parallel_for(indices.size(), [&](std::size_t i) {
      const auto position = positions_.find(indices[i]);
      if (!clouds[i] || position == positions_.end()) return;
      clouds[i] = moving_or_static_points(clouds[i], marks_.get(position->second), moving);
    });
    return clouds;
  }

 private:
  using Position = std::size_t;  // in poses_
  using Clouds = std::map<Position, PointCloudPtr>;

  static PointCloudPtr moving_or_static_points(const PointCloudPtr& cloud, const Marks& marks,
                                               bool moving) {
    auto result = std::make_shared<PointCloud>();
    result->points.reserve(moving ? marks.size() : cloud->size() - marks.size());
    auto next = marks.begin();
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      const bool is_moving = next != marks.end() && *next == i;
      if (is_moving) ++next;
      if (is_moving == moving) result->points.push_back(cloud->points[i]);
    }
    return result;
  }

  /// Marks the moving points of the batch to which this key frame belongs.
  void mark_batch(Position position) {
    const Position begin = position / kBatchSize * kBatchSize;
    const Position end = std::min(poses_.size(), begin + kBatchSize);
    const Clouds clouds = update_observers(begin, end);
    std::vector<Marks> marks(end - begin);
    parallel_for(marks.size(), [&](std::size_t i) {
      const auto cloud = clouds.find(begin + i);
      if (cloud != clouds.end()) marks[i] = marks_of(begin + i, *cloud->second);
    });
    for (std::size_t i = 0; i < marks.size(); ++i) marks_.put(begin + i, marks[i]);
  }

  /// Creates observers of the key frames around [begin, end) and deletes all others. Returns the
  /// clouds of that range.
  Clouds update_observers(Position begin, Position end) {
    const Position first = first_of(begin, config_.neighbours);
    const Position last = end_of(end - 1, config_.neighbours);
    observers_.erase(observers_.begin(), observers_.lower_bound(first));
    observers_.erase(observers_.lower_bound(last), observers_.end());
    std::vector<Position> needed;
    for (Position i = first; i < last; ++i) {
      const bool is_in_batch = i >= begin && i < end;
      if (is_in_batch || observers_.count(i) == 0) needed.push_back(i);
    }
    Clouds clouds_of_batch;
    Clouds new_clouds;
    for (const auto& [i, cloud] : clouds_at(needed)) {
      if (i >= begin && i < end) clouds_of_batch.emplace(i, cloud);
      if (observers_.count(i) == 0) new_clouds.emplace(i, cloud);
    }
    add_observers({new_clouds.begin(), new_clouds.end()});
    return clouds_of_batch;
  }

  /// The clouds of these key frames, without missing ones.
  Clouds clouds_at(const std::vector<Position>& positions) {
    std::vector<KeyFrameIndex> indices;
    for (const Position position : positions) indices.push_back(poses_[position].index);
    const std::vector<PointCloudPtr> found = clouds_.clouds(indices, config_.threads);
    Clouds clouds;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (found[i]) clouds.emplace(positions[i], found[i]);
    }
    return clouds;
  }

  void add_observers(const std::vector<std::pair<Position, PointCloudPtr>>& clouds) {
    std::vector<std::unique_ptr<ObservingScan>> created(clouds.size());
    parallel_for(clouds.size(), [&](std::size_t i) {
      created[i] =
          std::make_unique<ObservingScan>(observing_scan_of(clouds[i].first, *clouds[i].second));
    });
    for (std::size_t i = 0; i < clouds.size(); ++i)
      observers_[clouds[i].first] = std::move(created[i]);
  }

  ObservingScan observing_scan_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = poses_[position].T_map_base;
    const Pose T_base_sensor{Eigen::Quaterniond::Identity(), p_base_sensor_};
    return {(T_map_base * T_base_sensor).inverse(), RangeImage(cloud, p_base_sensor_.cast<float>()),
            ground_columns(TransformedPoints(cloud, T_map_base))};
  }

  Marks marks_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = poses_[position].T_map_base;
    const TransformedPoints points(cloud, T_map_base);
    const std::vector<const ObservingScan*> observers = observers_nearest_first(position);
    std::vector<Layer> layers = classify_layers(position, points);
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

  std::vector<Layer> classify_layers(Position position, const TransformedPoints& points) const {
    GroundModels ground_models(points);
    ground_models.own.add(observers_.at(position)->ground);
    for (Position i = first_of(position, config_.neighbours);
         i < end_of(position, config_.neighbours); ++i) {
      const auto observer = observers_.find(i);
      if (observer == observers_.end()) continue;
      const Position distance = i > position ? i - position : position - i;
      if (distance <= kGroundNeighbours) ground_models.near.add(observer->second->ground);
      if (distance % kGroundStep == 0) ground_models.wide.add(observer->second->ground);
    }
    return moving_objects::classify_layers(points, ground_models);
  }

  /// The observers around, nearest first, because these usually decide.
  std::vector<const ObservingScan*> observers_nearest_first(Position position) const {
    std::vector<const ObservingScan*> nearest;
    for (Position step = 1; step <= static_cast<Position>(config_.neighbours); ++step) {
      // indices below 0 wrap and are not found
      for (const Position other : {position - step, position + step}) {
        const auto observer = observers_.find(other);
        if (observer != observers_.end()) nearest.push_back(observer->second.get());
      }
    }
    return nearest;
  }

  Position first_of(Position position, int neighbours) const {
    const auto count = static_cast<Position>(neighbours);
    return position > count ? position - count : 0;
  }
  Position end_of(Position position, int neighbours) const {
    return std::min(poses_.size(), position + static_cast<Position>(neighbours) + 1);
  }

  void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) const {
    parallel_chunks(count, 1, config_.threads, [&](std::size_t i, std::size_t) { body(i); });
  }

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Eigen::Vector3d p_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, Position> positions_;
  std::map<Position, std::unique_ptr<ObservingScan>> observers_;
  MarkFile marks_;  ///< Moving points.
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
