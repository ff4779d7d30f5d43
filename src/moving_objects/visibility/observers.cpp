// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/observers.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/common/parallel.hpp"

namespace lidar_mapping::moving_objects {

namespace {

// Key frames of a batch. Chosen: more need more memory, and few processors have more cores.
constexpr std::size_t kBatchSize = 16;
// Neighbours on each side whose points give the near ground. Chosen: 20 key frames cover the
// surroundings of one, and farther ones see its ground from the other side of a crest.
constexpr std::size_t kGroundNeighbours = 10;
// Every n-th of the further ones gives the wide ground. Chosen: consecutive ones see much the same.
constexpr std::size_t kGroundStep = 3;

}  // namespace

Observers::Observers(CloudSource& clouds, const KeyFramePoses& poses,
                     const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config)
    : clouds_(clouds),
      poses_(poses.poses),
      visits_(poses.poses),
      p_base_sensor_(p_base_sensor),
      config_(config) {
  for (Position i = 0; i < poses_.size(); ++i) positions_[poses_[i].index] = i;
}

std::optional<Observers::Position> Observers::position_of(KeyFrameIndex index) const {
  const auto found = positions_.find(index);
  if (found == positions_.end()) return std::nullopt;
  return found->second;
}

Observers::Batch Observers::batch_of(Position position) const {
  const Position begin = position / kBatchSize * kBatchSize;
  Batch batch{begin, std::min(poses_.size(), begin + kBatchSize), {}};
  for (Position i = begin; i < batch.end; ++i) batch.indices.push_back(poses_[i].index);
  return batch;
}

void Observers::insert_neighbours(Position position, std::set<Position>& positions) const {
  const auto [begin, end] = neighbours_of(position);
  for (Position i = begin; i < end; ++i) positions.insert(i);
}

void Observers::keep(const std::set<Position>& positions) {
  for (auto observer = observers_.begin(); observer != observers_.end();) {
    observer =
        positions.count(observer->first) > 0 ? std::next(observer) : observers_.erase(observer);
  }
  std::vector<Position> missing;
  for (const Position position : positions) {
    if (observers_.count(position) == 0) missing.push_back(position);
  }
  add(missing);
}

void Observers::add(const std::vector<Position>& positions) {
  std::vector<KeyFrameIndex> indices;
  for (const Position position : positions) indices.push_back(poses_[position].index);
  const std::vector<PointCloudPtr> clouds = clouds_.clouds(indices, config_.threads);
  std::vector<std::unique_ptr<ObservingScan>> created(clouds.size());
  parallel_chunks(clouds.size(), 1, config_.threads, [&](std::size_t i, std::size_t) {
    if (!clouds[i]) return;
    created[i] = std::make_unique<ObservingScan>(observing_scan_of(positions[i], *clouds[i]));
  });
  for (std::size_t i = 0; i < created.size(); ++i) {
    if (created[i]) observers_[positions[i]] = std::move(created[i]);
  }
}

ObservingScan Observers::observing_scan_of(Position position, const PointCloud& cloud) const {
  const Pose& T_map_base = poses_[position].T_map_base;
  const Pose T_base_sensor{Eigen::Quaterniond::Identity(), p_base_sensor_};
  return {(T_map_base * T_base_sensor).inverse(), RangeImage(cloud, p_base_sensor_.cast<float>()),
          ground_columns(TransformedPoints(cloud, T_map_base))};
}

const ObservingScan* Observers::at(Position position) const {
  const auto found = observers_.find(position);
  return found == observers_.end() ? nullptr : found->second.get();
}

std::pair<Observers::Position, Observers::Position> Observers::neighbours_of(
    Position position) const {
  const auto count = static_cast<Position>(config_.neighbours);
  const auto is_same_visit = [&](Position other) {
    return visits_.visit_of(other) == visits_.visit_of(position);
  };
  Position begin = position;
  while (begin > 0 && position - begin < count && is_same_visit(begin - 1)) --begin;
  Position end = position + 1;
  while (end < poses_.size() && end - position <= count && is_same_visit(end)) ++end;
  return {begin, end};
}

std::vector<Layer> Observers::layers(Position position, const TransformedPoints& points) const {
  GroundModels ground_models(points);
  ground_models.own.add(observers_.at(position)->ground);
  const auto [begin, end] = neighbours_of(position);
  for (Position i = begin; i < end; ++i) {
    const ObservingScan* observer = at(i);
    if (observer == nullptr) continue;
    const Position distance = i > position ? i - position : position - i;
    if (distance <= kGroundNeighbours) ground_models.near.add(observer->ground);
    if (distance % kGroundStep == 0) ground_models.wide.add(observer->ground);
  }
  return classify_layers(points, ground_models);
}

}  // namespace lidar_mapping::moving_objects
