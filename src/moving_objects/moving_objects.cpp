// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/moving_objects.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <memory>

#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/moving_objects/placed_points.hpp"

#include "mark_file.hpp"
#include "moving_things.hpp"
#include "observing_scan.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kBatch = 16;     // key frames that are judged together, one a thread
constexpr int kGroundNeighbours = 10;  // key frames whose points tell the ground
constexpr int kGroundStep = 3;         // every so many of the further ones do, too
constexpr double kRain = 0.002;        // of the points alone in the air: it rains or snows

/// What is on the ground or at the foot of something needs no votes.
std::vector<std::uint32_t> voted_on(const std::vector<Layer>& layers) {
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

  /// The points that move, or that do not, of each.
  std::vector<PointCloudPtr> parts(const std::vector<KeyFrameIndex>& indices, bool moving) {
    std::vector<PointCloudPtr> clouds = clouds_.clouds(indices, config_.threads);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto position = positions_.find(indices[i]);
      if (!clouds[i] || position == positions_.end()) continue;
      if (!marks_.contains(position->second)) judge_around(position->second);
    }
    in_parallel(indices.size(), [&](std::size_t i) {
      const auto position = positions_.find(indices[i]);
      if (!clouds[i] || position == positions_.end()) return;
      clouds[i] = part(clouds[i], marks_.get(position->second), moving);
    });
    return clouds;
  }

 private:
  using Position = std::size_t;  // in poses_
  using Clouds = std::map<Position, PointCloudPtr>;

  static PointCloudPtr part(const PointCloudPtr& cloud, const Marks& marks, bool moving) {
    auto result = std::make_shared<PointCloud>();
    result->points.reserve(moving ? marks.size() : cloud->size() - marks.size());
    auto next = marks.begin();
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      const bool moves = next != marks.end() && *next == i;
      if (moves) ++next;
      if (moves == moving) result->points.push_back(cloud->points[i]);
    }
    return result;
  }

  /// Marks the key frames of the batch to which that one belongs.
  void judge_around(Position position) {
    const Position begin = position / kBatch * kBatch;
    const Position end = std::min(poses_.size(), begin + kBatch);
    const Clouds clouds = gather_observers(begin, end);
    std::vector<Marks> marks(end - begin);
    in_parallel(marks.size(), [&](std::size_t i) {
      const auto cloud = clouds.find(begin + i);
      if (cloud != clouds.end()) marks[i] = marks_of(begin + i, *cloud->second);
    });
    for (std::size_t i = 0; i < marks.size(); ++i) marks_.put(begin + i, marks[i]);
  }

  /// Makes observers of all around [begin, end), and lets go of the others. Returns the clouds of
  /// that range.
  Clouds gather_observers(Position begin, Position end) {
    const Position first = first_of(begin, config_.neighbours);
    const Position last = end_of(end - 1, config_.neighbours);
    observers_.erase(observers_.begin(), observers_.lower_bound(first));
    observers_.erase(observers_.lower_bound(last), observers_.end());
    std::vector<Position> wanted;
    for (Position i = first; i < last; ++i) {
      const bool is_judged = i >= begin && i < end;
      if (is_judged || observers_.count(i) == 0) wanted.push_back(i);
    }
    Clouds judged;
    Clouds fresh;
    for (const auto& [i, cloud] : clouds_at(wanted)) {
      if (i >= begin && i < end) judged.emplace(i, cloud);
      if (observers_.count(i) == 0) fresh.emplace(i, cloud);
    }
    add_observers({fresh.begin(), fresh.end()});
    return judged;
  }

  /// Without those that are missing.
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
    std::vector<std::unique_ptr<ObservingScan>> made(clouds.size());
    in_parallel(clouds.size(), [&](std::size_t i) {
      made[i] =
          std::make_unique<ObservingScan>(observing_scan_of(clouds[i].first, *clouds[i].second));
    });
    for (std::size_t i = 0; i < clouds.size(); ++i)
      observers_[clouds[i].first] = std::move(made[i]);
  }

  ObservingScan observing_scan_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = poses_[position].T_map_base;
    const Pose T_base_sensor{Eigen::Quaterniond::Identity(), p_base_sensor_};
    return {(T_map_base * T_base_sensor).inverse(), RangeImage(cloud, p_base_sensor_.cast<float>()),
            ground_columns(PlacedPoints(cloud, T_map_base))};
  }

  Marks marks_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = poses_[position].T_map_base;
    const PlacedPoints points(cloud, T_map_base);
    const std::vector<const ObservingScan*> observers = nearest_first(position);
    std::vector<Layer> layers = layers_of(position, points);
    const std::vector<Vote> votes =
        votes_on(cloud, T_map_base, voted_on(layers), observers, config_);
    for (const std::uint32_t drop :
         drops_of(cloud, T_map_base, lonely_points(points, votes), observers)) {
      layers[drop] = Layer::kAlone;
    }
    return moving_points(points, votes, layers);
  }

  /// None where it is dry: few points that are alone belong to things. Who has no neighbours to
  /// decide with has to be seen through more clearly.
  Marks drops_of(const PointCloud& cloud, const Pose& T_map_base,
                 const std::vector<std::uint32_t>& alone,
                 const std::vector<const ObservingScan*>& observers) const {
    MovingObjectsConfig surer = config_;
    surer.min_votes *= 2;
    surer.min_share = 0.5 * (1.0 + config_.min_share);
    const std::vector<Vote> votes = votes_on(cloud, T_map_base, alone, observers, surer);
    Marks drops;
    std::copy_if(alone.begin(), alone.end(), std::back_inserter(drops),
                 [&](std::uint32_t i) { return votes[i] == Vote::kMoves; });
    if (static_cast<double>(drops.size()) < kRain * static_cast<double>(cloud.size()))
      drops.clear();
    return drops;
  }

  std::vector<Layer> layers_of(Position position, const PlacedPoints& points) const {
    Grounds grounds(points);
    grounds.own.add(observers_.at(position)->ground);
    for (Position i = first_of(position, config_.neighbours);
         i < end_of(position, config_.neighbours); ++i) {
      const auto observer = observers_.find(i);
      if (observer == observers_.end()) continue;
      const Position distance = i > position ? i - position : position - i;
      if (distance <= kGroundNeighbours) grounds.near.add(observer->second->ground);
      if (distance % kGroundStep == 0) grounds.wide.add(observer->second->ground);
    }
    return moving_objects::layers_of(points, grounds);
  }

  /// The others around; those near by mostly settle a case.
  std::vector<const ObservingScan*> nearest_first(Position position) const {
    std::vector<const ObservingScan*> nearest;
    for (Position step = 1; step <= static_cast<Position>(config_.neighbours); ++step) {
      for (const Position other : {position - step, position + step}) {  // below 0 is none's
        const auto observer = observers_.find(other);
        if (observer != observers_.end()) nearest.push_back(observer->second.get());
      }
    }
    return nearest;
  }

  Position first_of(Position position, int neighbours) const {
    const auto reach = static_cast<Position>(neighbours);
    return position > reach ? position - reach : 0;
  }
  Position end_of(Position position, int neighbours) const {
    return std::min(poses_.size(), position + static_cast<Position>(neighbours) + 1);
  }

  void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body) const {
    parallel_chunks(count, 1, config_.threads, [&](std::size_t i, std::size_t) { body(i); });
  }

  CloudSource& clouds_;
  const std::vector<KeyFramePose> poses_;
  const Eigen::Vector3d p_base_sensor_;
  const MovingObjectsConfig config_;
  std::map<KeyFrameIndex, Position> positions_;
  std::map<Position, std::unique_ptr<ObservingScan>> observers_;
  MarkFile marks_;  ///< of points that move
};

StaticClouds::StaticClouds(CloudSource& clouds, const KeyFramePoses& poses,
                           const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config,
                           const std::filesystem::path& directory)
    : impl_(std::make_unique<Impl>(clouds, poses, p_base_sensor, config, directory)) {}
StaticClouds::~StaticClouds() = default;

PointCloudPtr StaticClouds::cloud(KeyFrameIndex index) {
  return impl_->parts({index}, false).front();
}
std::vector<PointCloudPtr> StaticClouds::clouds(const std::vector<KeyFrameIndex>& indices,
                                                int /*threads*/) {
  return impl_->parts(indices, false);
}
PointCloudPtr StaticClouds::removed(KeyFrameIndex index) {
  return impl_->parts({index}, true).front();
}

}  // namespace lidar_mapping::moving_objects
