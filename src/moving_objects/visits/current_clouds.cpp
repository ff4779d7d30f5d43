// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/current_clouds.hpp"

#include <set>

#include "lidar_mapping/common/list_file.hpp"
#include "lidar_mapping/common/parallel.hpp"

#include "marks.hpp"
#include "visibility/observers.hpp"
#include "visits/other_visits.hpp"
#include "visits/point_history.hpp"

namespace lidar_mapping::moving_objects {

class CurrentClouds::Impl {
 public:
  Impl(CloudSource& observed, CloudSource& clouds, const KeyFramePoses& poses,
       const Eigen::Vector3d& p_base_sensor, const MovingObjectsConfig& config,
       const std::filesystem::path& directory)
      : clouds_(clouds),
        config_(config),
        visits_(poses.poses),
        other_visits_(poses.poses, visits_),
        observers_(observed, poses, p_base_sensor, config),
        marks_(directory) {}

  std::vector<PointCloudPtr> current(const std::vector<KeyFrameIndex>& indices) {
    std::vector<PointCloudPtr> clouds = clouds_.clouds(indices, config_.threads);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto position = observers_.position_of(indices[i]);
      if (clouds[i] && position && !marks_.contains(*position)) mark_batch(*position);
    }
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto position = observers_.position_of(indices[i]);
      if (clouds[i] && position) {
        clouds[i] = unmarked_points(*clouds[i], marks_.get(*position));
      }
    }
    return clouds;
  }

  std::vector<Change> changes() {
    if (visits_.visits().size() < 2) return {};
    for (Position i = 0; i < observers_.poses().size(); ++i) {
      if (!marks_.contains(i)) mark_batch(i);
    }
    return changes_.changes();
  }

  const Visits& visits() const { return visits_; }
  std::size_t outdated() const { return outdated_; }

 private:
  using Position = Observers::Position;

  /// What the other visits tell of a key frame.
  struct Result {
    Marks outdated;
    ChangeList changes;
  };

  /// Looks at the batch to which this key frame belongs.
  void mark_batch(Position position) {
    const Observers::Batch batch = observers_.batch_of(position);
    observers_.keep(observers_of(batch));
    const std::vector<PointCloudPtr> clouds = clouds_.clouds(batch.indices, config_.threads);
    std::vector<Result> results(clouds.size());
    parallel_chunks(clouds.size(), 1, config_.threads, [&](std::size_t i, std::size_t) {
      if (clouds[i] && observers_.at(batch.begin + i) != nullptr) {
        results[i] = result_of(batch.begin + i, *clouds[i]);
      }
    });
    for (std::size_t i = 0; i < results.size(); ++i) {
      marks_.put(batch.begin + i, results[i].outdated);
      outdated_ += results[i].outdated.size();
      changes_.add(results[i].changes);
    }
  }

  /// Those of the other visits near these key frames, and those that know the ground there.
  std::set<Position> observers_of(const Observers::Batch& batch) const {
    std::set<Position> needed;
    for (Position i = batch.begin; i < batch.end; ++i) {
      for (const auto& [visit, positions] : other_visits_.near(i)) {
        needed.insert(positions.begin(), positions.end());
      }
      observers_.insert_neighbours(i, needed);
    }
    return needed;
  }

  Result result_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = observers_.poses()[position].T_map_base;
    const PointHistory history = history_of(position, cloud);
    Result result;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      const auto gone = history.disappeared(i);
      const auto came = history.appeared(i);
      if (gone) result.outdated.push_back(i);
      for (const auto& change : {came, gone}) {
        if (!change) continue;
        result.changes.add(T_map_base * cloud.points[i].position().cast<double>(), *change);
      }
    }
    return result;
  }

  PointHistory history_of(Position position, const PointCloud& cloud) const {
    const Pose& T_map_base = observers_.poses()[position].T_map_base;
    PointHistory history(visits_.visit_of(position), cloud.size());
    const auto others = other_visits_.near(position);
    if (others.empty()) return history;
    const TransformedPoints points(cloud, T_map_base);
    const std::vector<Layer> layers = observers_.layers(position, points);
    const std::vector<std::uint32_t> voted = voted_points(layers);
    for (const auto& [visit, positions] : others) {
      const std::vector<Vote> votes =
          collect_votes(cloud, T_map_base, voted, observers_at(positions), config_);
      history.add(visit, votes, outvoted_points(points, votes, layers));
    }
    return history;
  }

  std::vector<const ObservingScan*> observers_at(const std::vector<Position>& positions) const {
    std::vector<const ObservingScan*> observers;
    for (const Position position : positions) {
      const ObservingScan* observer = observers_.at(position);
      if (observer != nullptr) observers.push_back(observer);
    }
    return observers;
  }

  CloudSource& clouds_;
  const MovingObjectsConfig config_;
  const Visits visits_;
  const OtherVisits other_visits_;
  Observers observers_;
  ListFile<Position, Marks::value_type> marks_;  ///< Points that are outdated.
  ChangeList changes_;
  std::size_t outdated_ = 0;
};

CurrentClouds::CurrentClouds(CloudSource& observed, CloudSource& clouds, const KeyFramePoses& poses,
                             const Eigen::Vector3d& p_base_sensor,
                             const MovingObjectsConfig& config,
                             const std::filesystem::path& directory)
    : impl_(std::make_unique<Impl>(observed, clouds, poses, p_base_sensor, config, directory)) {}
CurrentClouds::~CurrentClouds() = default;

PointCloudPtr CurrentClouds::cloud(KeyFrameIndex index) { return impl_->current({index}).front(); }
std::vector<PointCloudPtr> CurrentClouds::clouds(const std::vector<KeyFrameIndex>& indices,
                                                 int /*threads*/) {
  return impl_->current(indices);
}
const Visits& CurrentClouds::visits() const { return impl_->visits(); }
std::vector<Change> CurrentClouds::changes() { return impl_->changes(); }
std::size_t CurrentClouds::outdated() const { return impl_->outdated(); }

}  // namespace lidar_mapping::moving_objects
