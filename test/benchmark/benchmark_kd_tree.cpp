// SPDX-License-Identifier: BSD-3-Clause
// The kd-tree of loop closing against nanoflann: the points of a submap and the queries of a loop
// in the simulated town, for a sensor with few rings and one with many.

#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <nanoflann.hpp>

#include "lidar_mapping/loop_closing/loop_closing_config.hpp"
#include "lidar_mapping/loop_closing/voxel_means.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "point_to_plane.hpp"
#include "verification.hpp"

namespace lidar_mapping::loop_closing {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr std::size_t kMiddle = 80;    // scan at the speed of a town, which is 8 s after the start
constexpr std::size_t kSpacing = 4;    // scans from key frame to key frame, some metres
constexpr float kNear = 0.6F;          // m, limit of the last level of point_to_plane.cpp
constexpr float kFar = 5.0F;           // m, limit of its first level
constexpr double kFitnessRange = 2.0;  // m, as LoopClosingConfig has it
constexpr std::size_t kNeighbours = 10;  // of a normal (surface.cpp)

/// What one loop asks of a tree.
struct Loop {
  Points submap;   ///< of eleven key frames, thinned as in a drive
  Points queries;  ///< of one key frame beside its true pose, as in the first iterations
};

Points thinned(const Points& points) {
  VoxelMeans means;
  means.reset(LoopClosingConfig().map_leaf_size);
  for (const Eigen::Vector3f& p : points) means.add(p);
  return means.points();
}

Loop simulated_loop(const std::string& lidar) {
  simulation::DriveOptions options;
  options.lidar = lidar;
  options.undistorted = true;
  options.duration = 16.0;
  const simulation::Drive drive(options);
  const auto extent = static_cast<std::size_t>(LoopClosingConfig().extend_frame_num);
  const Pose T_middle_map = drive.trajectory().pose(drive.scan_stamp(kMiddle)).inverse();
  const auto points_of = [&](std::size_t scan, const Pose& offset) {
    const Pose T = T_middle_map * drive.trajectory().pose(drive.scan_stamp(scan)) * offset;
    Points points;
    for (const Point& point : drive.base_scan(scan).cloud.points) {
      points.push_back((T * point.position().cast<double>()).cast<float>());
    }
    return points;
  };
  Loop loop;
  for (std::size_t k = 0; k <= 2 * extent; ++k) {
    const Points points = points_of(kMiddle + kSpacing * k - kSpacing * extent, Pose());
    loop.submap.insert(loop.submap.end(), points.begin(), points.end());
  }
  loop.submap = thinned(loop.submap);
  const Pose error{exp_so3({0.0, 0.0, 0.02}), {0.4, 0.2, 0.1}};
  loop.queries = thinned(points_of(kMiddle + kSpacing / 2, error));
  return loop;
}

const Loop& loop_of(const std::string& lidar) {
  static std::map<std::string, Loop> loops;
  const auto found = loops.find(lidar);
  return found != loops.end() ? found->second
                              : loops.emplace(lidar, simulated_loop(lidar)).first->second;
}

// Both sets of results stay sorted and are bounded by their worst distance; nanoflann compares with
// the worst distance at the beginning of a leaf, so that they have to compare again.

/// The nearest point within a limit.
struct NearestOne {
  explicit NearestOne(float limit) : worst(limit * limit) {}
  bool addPoint(float squared_distance, std::uint32_t candidate) {
    if (squared_distance >= worst) return true;
    worst = squared_distance;
    index = candidate;
    found = true;
    return true;
  }
  float worstDist() const { return worst; }
  bool full() const { return found; }
  std::size_t size() const { return found ? 1 : 0; }

  float worst;
  std::uint32_t index = 0;
  bool found = false;
};

/// The nearest point within a limit, and the distance of the second one.
struct NearestTwo {
  explicit NearestTwo(float limit) : nearest(limit * limit), second(nearest) {}
  bool addPoint(float squared_distance, std::uint32_t candidate) {
    if (squared_distance >= second) return true;
    second = squared_distance;
    if (squared_distance >= nearest) return true;
    std::swap(nearest, second);
    index = candidate;
    found = true;
    return true;
  }
  float worstDist() const { return second; }
  bool full() const { return found; }
  std::size_t size() const { return found ? 1 : 0; }

  float nearest;
  float second;
  std::uint32_t index = 0;
  bool found = false;
};

/// Several nearest points, sorted by distance.
struct NearestSeveral {
  explicit NearestSeveral(std::size_t wanted) : count(wanted) { kept.reserve(wanted); }
  bool addPoint(float squared_distance, std::uint32_t candidate) {
    if (squared_distance >= worst) return true;
    if (kept.size() < count) kept.emplace_back();
    auto position = kept.end() - 1;
    for (; position != kept.begin() && squared_distance < (position - 1)->squared_distance;
         --position) {
      *position = *(position - 1);
    }
    *position = {candidate, squared_distance};
    if (full()) worst = kept.back().squared_distance;
    return true;
  }
  float worstDist() const { return worst; }
  bool full() const { return kept.size() == count; }
  std::size_t size() const { return kept.size(); }

  std::size_t count;
  float worst = std::numeric_limits<float>::infinity();
  std::vector<KdTree::Neighbour> kept;
};

/// nanoflann's tree, with the searches of KdTree. Tried: points in the order of the leaves, as
/// KdTree has them, do not make it faster.
class Nanoflann {
 public:
  explicit Nanoflann(Points points) : set_{std::move(points)}, tree_(3, set_, {kLeafSize}) {}

  const Points& points() const { return set_.points; }
  std::optional<KdTree::Neighbour> nearest(const Eigen::Vector3f& p, float limit) const {
    NearestOne result(limit);
    tree_.findNeighbors(result, p.data(), {});
    if (!result.found) return std::nullopt;
    return KdTree::Neighbour{result.index, result.worst};
  }
  std::optional<KdTree::NearestWithSecond> nearest_with_second(const Eigen::Vector3f& p,
                                                               float limit) const {
    NearestTwo result(limit);
    tree_.findNeighbors(result, p.data(), {});
    if (!result.found) return std::nullopt;
    return KdTree::NearestWithSecond{{result.index, result.nearest}, result.second};
  }
  std::vector<KdTree::Neighbour> nearest(const Eigen::Vector3f& p, std::size_t count) const {
    NearestSeveral result(count);
    tree_.findNeighbors(result, p.data(), {});
    return std::move(result.kept);
  }

 private:
  // Points of a leaf. Tried: 24 is the best of 6, 10 (the default), 16 and 24.
  static constexpr std::size_t kLeafSize = 24;

  struct PointSet {
    std::size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(std::size_t index, std::size_t axis) const {
      return points[index][static_cast<Eigen::Index>(axis)];
    }
    template <typename Box>
    bool kdtree_get_bbox(Box& /*box*/) const {
      return false;
    }
    Points points;
  };
  using Metric = nanoflann::L2_Simple_Adaptor<float, PointSet, float, std::uint32_t>;

  PointSet set_;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, 3, std::uint32_t> tree_;
};

template <typename Tree>
const Tree& tree_of(const std::string& lidar) {
  static std::map<std::string, std::unique_ptr<Tree>> trees;
  std::unique_ptr<Tree>& tree = trees[lidar];
  if (!tree) tree = std::make_unique<Tree>(loop_of(lidar).submap);
  return *tree;
}

template <typename Tree>
void build(benchmark::State& state, const std::string& lidar) {
  const Points& points = loop_of(lidar).submap;
  for (auto _ : state) {
    Tree tree(points);
    benchmark::DoNotOptimize(tree.points().data());
  }
  state.counters["points"] = static_cast<double>(points.size());
}

/// Calls `search` with all queries in turn, and gives the time of one.
template <typename Search>
void run(benchmark::State& state, const Points& queries, const Search& search) {
  for (auto _ : state) {
    for (const Eigen::Vector3f& p : queries) benchmark::DoNotOptimize(search(p));
  }
  state.counters["per_query"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(queries.size()),
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

template <typename Tree>
void one(benchmark::State& state, const std::string& lidar) {
  const Tree& tree = tree_of<Tree>(lidar);
  run(state, loop_of(lidar).queries,
      [&](const Eigen::Vector3f& p) { return tree.nearest(p, kNear); });
}

template <typename Tree>
void with_second(benchmark::State& state, const std::string& lidar) {
  const Tree& tree = tree_of<Tree>(lidar);
  run(state, loop_of(lidar).queries,
      [&](const Eigen::Vector3f& p) { return tree.nearest_with_second(p, kFar); });
}

template <typename Tree>
void ten(benchmark::State& state, const std::string& lidar) {
  const Tree& tree = tree_of<Tree>(lidar);
  // Both know the same points, in orders of their own.
  run(state, loop_of(lidar).submap,
      [&](const Eigen::Vector3f& p) { return tree.nearest(p, kNeighbours); });
}

template <typename Tree>
void register_tree(const std::string& name, const std::string& lidar) {
  const auto add = [&](const std::string& what,
                       void (*function)(benchmark::State&, const std::string&)) {
    benchmark::RegisterBenchmark((what + "/" + lidar + "/" + name).c_str(), function, lidar)
        ->Unit(benchmark::kMillisecond);
  };
  add("build", build<Tree>);
  add("nearest", one<Tree>);
  add("nearest_with_second", with_second<Tree>);
  add("ten_nearest", ten<Tree>);
}

/// All that loop closing does with a submap: tree, match and figures.
void whole_loop(benchmark::State& state, const std::string& lidar) {
  const Loop& loop = loop_of(lidar);
  QueryScan query;
  query.points = loop.queries;
  query.above_ground = above_ground(loop.queries);
  Submap submap;
  submap.above_ground.assign(loop.submap.size(), false);
  for (auto _ : state) {
    submap.surface = SurfaceCloud(loop.submap);
    const Alignment alignment = align_point_to_plane(query.points, submap.surface, Pose());
    benchmark::DoNotOptimize(
        measure_match(query, submap, alignment.T_target_source, kFitnessRange).overlap);
  }
}

/// Whether both trees find the same distances; they are no rivals otherwise.
bool agree(const std::string& lidar) {
  const auto& own = tree_of<KdTree>(lidar);
  const auto& other = tree_of<Nanoflann>(lidar);
  const auto near = [](float a, float b) { return std::abs(a - b) <= 1e-6F * (1.0F + a); };
  for (const Eigen::Vector3f& p : loop_of(lidar).queries) {
    const auto a = own.nearest_with_second(p, kFar);
    const auto b = other.nearest_with_second(p, kFar);
    if (a.has_value() != b.has_value()) return false;
    if (!a) continue;
    if (!near(a->nearest.squared_distance, b->nearest.squared_distance)) return false;
    if (!near(a->second_squared_distance, b->second_squared_distance)) return false;
    const auto many = own.nearest(p, kNeighbours);
    const auto others = other.nearest(p, kNeighbours);
    if (many.size() != others.size()) return false;
    for (std::size_t i = 0; i < many.size(); ++i) {
      if (!near(many[i].squared_distance, others[i].squared_distance)) return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace lidar_mapping::loop_closing

int main(int argc, char** argv) {
  using namespace lidar_mapping::loop_closing;
  benchmark::Initialize(&argc, argv);
  for (const char* lidar : {"vlp16", "hdl64"}) {
    if (!agree(lidar)) {
      std::fprintf(stderr, "the two trees find different neighbours (%s)\n", lidar);
      return EXIT_FAILURE;
    }
    register_tree<KdTree>("own", lidar);
    register_tree<Nanoflann>("nanoflann", lidar);
    benchmark::RegisterBenchmark((std::string("whole_loop/") + lidar).c_str(), whole_loop,
                                 std::string(lidar))
        ->Unit(benchmark::kMillisecond);
  }
  benchmark::RunSpecifiedBenchmarks();
  return EXIT_SUCCESS;
}
