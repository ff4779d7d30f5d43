#include "lidar_mapping/back_end/back_end.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "lidar_mapping/back_end/edge_covariance.hpp"
#include "lidar_mapping/back_end/optimization.hpp"
#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::back_end {

namespace {

constexpr std::size_t kWaitingLimit = 1000;

/// Measurements whose key frame has not come yet, bounded.
template <typename Value>
class Waiting {
 public:
  void add(Stamp stamp, const Value& value) {
    values_[stamp] = value;
    if (values_.size() > kWaitingLimit) values_.erase(values_.begin());
  }

  std::optional<Value> take(Stamp stamp) {
    const auto found = values_.find(stamp);
    if (found == values_.end()) return std::nullopt;
    std::optional<Value> value = found->second;
    values_.erase(found);
    return value;
  }

 private:
  std::map<Stamp, Value> values_;
};

/// Keeps `list` ordered by node; false if the node has its value already.
template <typename Value>
bool insert_by_node(const Value& value, std::vector<Value>& list) {
  const auto after =
      std::lower_bound(list.begin(), list.end(), value.node,
                       [](const Value& entry, int node) { return entry.node < node; });
  if (after != list.end() && after->node == value.node) return false;
  list.insert(after, value);
  return true;
}

bool usable(const GnssPosition& position, const BackEndConfig& config) {
  const Eigen::Matrix2d covariance = position.covariance.topLeftCorner<2, 2>();
  if (!position.p_enu_antenna.head<2>().allFinite() || !position.p_base_antenna.allFinite()) {
    return false;
  }
  if (!covariance.allFinite() || covariance(0, 0) <= 0.0 || covariance.determinant() <= 0.0) {
    return false;
  }
  return horizontal_stddev(position, config) <= config.gnss_max_stddev_m;
}

}  // namespace

class BackEnd::Impl {
 public:
  explicit Impl(const BackEndConfig& config) : config_(config) {}

  void add_key_frame(const KeyFrame& key_frame) {
    check(key_frame);
    DriveNode node;
    node.index = key_frame.index;
    node.stamp = key_frame.stamp;
    node.T_odom_base = key_frame.T_odom_base;
    node.T_map_base =
        drive_.nodes.empty() ? key_frame.T_odom_base : T_map_odom() * key_frame.T_odom_base;
    if (drive_.nodes.empty()) drive_.T_map_first = node.T_map_base;
    if (!drive_.nodes.empty()) {
      const Pose motion = drive_.nodes.back().T_odom_base.inverse() * node.T_odom_base;
      node.motion_covariance = odometry_covariance(key_frame.motion_covariance, motion,
                                                   key_frame.degenerate_directions, config_);
    }
    node.joined = !drive_.nodes.empty() && key_frame.segment == newest_segment_;
    if (!node.joined) {
      drive_.segment_starts.push_back(size());
      drive_.in_enu.push_back(false);
    }
    node.segment = static_cast<int>(drive_.segment_starts.size()) - 1;
    newest_segment_ = key_frame.segment;
    drive_.nodes.push_back(node);
    at_stamp_[node.stamp] = size() - 1;
    attach_waiting(node.stamp, waiting_gnss_);
    attach_waiting(node.stamp, waiting_imu_);
    attach_waiting(node.stamp, waiting_floors_);
    ++since_.key_frames;
  }

  bool add_loop(const Loop& loop) {
    const int from = position_of(loop.from);
    const int to = position_of(loop.to);
    if (from < 0 || to < 0 || from == to) return false;
    if (!is_finite(loop.T_from_to) || !is_valid_covariance(loop.covariance)) return false;
    const bool judged = loop.decision == LoopDecision::kRefuse;
    drive_.loops.push_back({loop, from, to, false, judged});
    ++since_.loops;
    return true;
  }

  void add_gnss(const GnssPosition& position) {
    if (!usable(position, config_)) {
      ++drive_.unusable_gnss;
      return;
    }
    attach_or_wait(position, waiting_gnss_);
  }

  void add_imu(const ImuSample& sample) {
    const bool known = sample.linear_acceleration.allFinite() &&
                       (!sample.orientation || sample.orientation->coeffs().allFinite());
    if (known) attach_or_wait(sample, waiting_imu_);
  }

  void add_floor(const Floor& floor) {
    const bool known =
        floor.normal.allFinite() && std::isfinite(floor.offset) && floor.covariance.allFinite();
    if (floor.found && known) attach_or_wait(floor, waiting_floors_);
  }

  bool optimization_due() const {
    if (drive_.nodes.empty()) return false;
    const double elapsed = to_seconds(drive_.nodes.back().stamp - last_optimization_);
    if (elapsed >= 0.0 && elapsed < config_.optimize_min_interval) return false;
    if (whole_needed_) return true;
    if (config_.use_loop_close && since_.loops >= config_.optimize_step_with_loop) return true;
    if (config_.use_gnss && since_.gnss >= gnss_step()) return true;
    // Odometry alone has nothing to distribute.
    const bool anything = (config_.use_loop_close && !drive_.loops.empty()) ||
                          (config_.use_gnss && !drive_.gnss.empty());
    return anything && since_.key_frames >= config_.optimize_step_with_key_frame;
  }

  std::shared_ptr<const OptimizationProblem> problem(bool thorough) const {
    auto problem = std::make_shared<OptimizationProblem>();
    problem->config = config_;
    problem->key_frames = drive_.nodes.size();
    problem->thorough = thorough;
    if (!thorough && !whole_due()) problem->window = window_of_news(drive_, config_);
    problem->drive = problem->window ? cut(drive_, *problem->window) : drive_;
    problem->judged = count_judgements(drive_);
    return problem;
  }

  KeyFramePoses apply(const OptimizationSolution& solution) {
    if (solution.drive.nodes.empty() || solution.key_frames > drive_.nodes.size()) return poses();
    if (solution.window) {
      apply_window(solution);
    } else {
      apply_whole(solution.drive);
    }
    since_.key_frames = size() - static_cast<int>(solution.key_frames);
    last_optimization_ = drive_.nodes[solution.key_frames - 1].stamp;
    ++revision_;
    return poses();
  }

  KeyFramePoses poses() const {
    KeyFramePoses result;
    result.revision = revision_;
    result.poses.reserve(drive_.nodes.size());
    for (const DriveNode& node : drive_.nodes) {
      result.poses.push_back({node.index, node.stamp, node.T_map_base});
    }
    return result;
  }

  Pose T_map_odom() const {
    if (drive_.nodes.empty()) return Pose::Identity();
    return drive_.nodes.back().T_map_base * drive_.nodes.back().T_odom_base.inverse();
  }

  std::vector<std::pair<Loop, bool>> loops() const {
    std::vector<std::pair<Loop, bool>> result;
    for (const DriveLoop& loop : drive_.loops) {
      result.emplace_back(loop.loop, loop.used || !loop.weighed);
    }
    return result;
  }

  std::vector<int> parts() const {
    std::vector<int> part_of = connected_segments(drive_, false);
    std::vector<bool> in_enu(part_of.size(), false);
    for (std::size_t s = 0; s < part_of.size(); ++s) {
      if (drive_.in_enu[s]) in_enu[static_cast<std::size_t>(part_of[s])] = true;
    }
    const auto first = std::find(in_enu.begin(), in_enu.end(), true) - in_enu.begin();
    for (int& part : part_of) {
      if (in_enu[static_cast<std::size_t>(part)]) part = static_cast<int>(first);
    }
    std::vector<int> result;
    for (const DriveNode& node : drive_.nodes) {
      result.push_back(part_of[static_cast<std::size_t>(node.segment)]);
    }
    return result;
  }

  PoseGraph graph() const;

 private:
  struct Counts {
    int key_frames = 0;
    int loops = 0;
    int gnss = 0;
  };

  /// A map that is not in East-North-Up yet should be soon.
  int gnss_step() const {
    constexpr int kFirstStep = 5;
    return drive_.in_enu.back() ? config_.optimize_step_with_gnss
                                : std::min(kFirstStep, config_.optimize_step_with_gnss);
  }

  int size() const { return static_cast<int>(drive_.nodes.size()); }

  void check(const KeyFrame& key_frame) const {
    if (!is_finite(key_frame.T_odom_base)) {
      throw InputError("key frame " + std::to_string(key_frame.index) +
                       " has a pose that is not finite; the front end must not send it");
    }
    if (drive_.nodes.empty() || key_frame.index > drive_.nodes.back().index) return;
    throw InputError("key frame " + std::to_string(key_frame.index) + " follows key frame " +
                     std::to_string(drive_.nodes.back().index) +
                     "; indices must increase over a run");
  }

  int position_of(KeyFrameIndex index) const {
    const auto found = std::lower_bound(
        drive_.nodes.begin(), drive_.nodes.end(), index,
        [](const DriveNode& node, KeyFrameIndex wanted) { return node.index < wanted; });
    if (found == drive_.nodes.end() || found->index != index) return -1;
    return static_cast<int>(found - drive_.nodes.begin());
  }

  template <typename Value>
  void attach_or_wait(const Value& value, Waiting<Value>& waiting) {
    const auto found = at_stamp_.find(value.stamp);
    if (found == at_stamp_.end()) {
      waiting.add(value.stamp, value);
    } else {
      attach(value, found->second);
    }
  }

  template <typename Value>
  void attach_waiting(Stamp stamp, Waiting<Value>& waiting) {
    if (const auto value = waiting.take(stamp)) attach(*value, at_stamp_.at(stamp));
  }

  void attach(const GnssPosition& position, int node) {
    if (insert_by_node(DriveGnss{position, node, false, false, false}, drive_.gnss)) ++since_.gnss;
  }
  void attach(const ImuSample& sample, int node) {
    insert_by_node(DriveImu{sample, node}, drive_.imu);
  }
  void attach(const Floor& floor, int node) {
    insert_by_node(DriveFloor{floor, node}, drive_.floors);
  }

  /// Small graphs are solved whole each time; large ones after each twentieth part that they have
  /// grown, and when a window could not settle what is new.
  bool whole_due() const {
    constexpr std::size_t kSmallGraph = 4000;
    return whole_needed_ || drive_.nodes.size() < kSmallGraph ||
           20 * (drive_.nodes.size() - last_whole_) > drive_.nodes.size();
  }

  void apply_whole(const DriveGraph& solved) {
    drive_.T_map_first = solved.T_map_first;
    std::copy(solved.in_enu.begin(), solved.in_enu.end(), drive_.in_enu.begin());
    for (std::size_t i = 0; i < solved.nodes.size(); ++i) {
      drive_.nodes[i].T_map_base = solved.nodes[i].T_map_base;
    }
    follow_from(solved.nodes.size());
    for (std::size_t i = 0; i < solved.loops.size(); ++i) drive_.loops[i] = solved.loops[i];
    for (const DriveGnss& gnss : solved.gnss) take_judgement(gnss, gnss.node);
    since_.loops = static_cast<int>(drive_.loops.size() - solved.loops.size());
    since_.gnss = static_cast<int>(drive_.gnss.size() - solved.gnss.size());
    last_whole_ = solved.nodes.size();
    whole_needed_ = false;
  }

  void apply_window(const OptimizationSolution& solution) {
    whole_needed_ = solution.whole_needed;
    if (whole_needed_) return;
    const DriveWindow& window = *solution.window;
    for (std::size_t i = 0; i < window.nodes.size(); ++i) {
      drive_.nodes[static_cast<std::size_t>(window.nodes[i])].T_map_base =
          solution.drive.nodes[i].T_map_base;
    }
    follow_from(solution.key_frames);
    for (std::size_t i = 0; i < window.loops.size(); ++i) {
      DriveLoop& loop = drive_.loops[static_cast<std::size_t>(window.loops[i])];
      loop.used = solution.drive.loops[i].used;
      loop.weighed = solution.drive.loops[i].weighed;
    }
    for (const DriveGnss& gnss : solution.drive.gnss) {
      take_judgement(gnss, window.nodes[static_cast<std::size_t>(gnss.node)]);
    }
    const auto is_new = [](const auto& value) { return !value.weighed; };
    since_.loops =
        static_cast<int>(std::count_if(drive_.loops.begin(), drive_.loops.end(), is_new));
    since_.gnss =
        config_.georeference_only
            ? 0
            : static_cast<int>(std::count_if(drive_.gnss.begin(), drive_.gnss.end(), is_new));
  }

  /// Lets the nodes that came during a solution follow odometry from those before.
  void follow_from(std::size_t first) {
    for (std::size_t i = first; i < drive_.nodes.size(); ++i) {
      const DriveNode& previous = drive_.nodes[i - 1];
      drive_.nodes[i].T_map_base =
          previous.T_map_base * previous.T_odom_base.inverse() * drive_.nodes[i].T_odom_base;
    }
  }

  void take_judgement(const DriveGnss& judged, int node) {
    const auto found =
        std::lower_bound(drive_.gnss.begin(), drive_.gnss.end(), node,
                         [](const DriveGnss& gnss, int wanted) { return gnss.node < wanted; });
    found->horizontal_used = judged.horizontal_used;
    found->altitude_used = judged.altitude_used;
    found->weighed = judged.weighed;
  }

  BackEndConfig config_;
  DriveGraph drive_;
  std::map<Stamp, int> at_stamp_;
  Waiting<GnssPosition> waiting_gnss_;
  Waiting<ImuSample> waiting_imu_;
  Waiting<Floor> waiting_floors_;
  std::uint32_t revision_ = 0;
  Counts since_;
  Stamp last_optimization_ = 0;
  std::uint32_t newest_segment_ = 0;  ///< as the front end numbers them
  std::size_t last_whole_ = 0;        ///< key frames when the whole graph was solved last
  bool whole_needed_ = false;
};

PoseGraph BackEnd::Impl::graph() const {
  PoseGraph graph;
  for (const DriveNode& node : drive_.nodes) graph.nodes.push_back({node.index, node.T_map_base});
  for (std::size_t i = 1; i < drive_.nodes.size(); ++i) {
    const DriveNode& a = drive_.nodes[i - 1];
    const DriveNode& b = drive_.nodes[i];
    if (!b.joined) continue;
    graph.edges.push_back({a.index, b.index, a.T_odom_base.inverse() * b.T_odom_base,
                           g2o_information(b.motion_covariance)});
  }
  for (const DriveLoop& loop : drive_.loops) {
    if (!loop.used) continue;
    graph.edges.push_back({loop.loop.from, loop.loop.to, loop.loop.T_from_to,
                           g2o_information(loop_covariance(loop.loop, config_))});
  }
  return graph;
}

BackEnd::BackEnd(const BackEndConfig& config) : impl_(std::make_unique<Impl>(config)) {}
BackEnd::~BackEnd() = default;

void BackEnd::add_key_frame(const KeyFrame& key_frame) { impl_->add_key_frame(key_frame); }
bool BackEnd::add_loop(const Loop& loop) { return impl_->add_loop(loop); }
void BackEnd::add_gnss(const GnssPosition& position) { impl_->add_gnss(position); }
void BackEnd::add_imu(const ImuSample& sample_base) { impl_->add_imu(sample_base); }
void BackEnd::add_floor(const Floor& floor) { impl_->add_floor(floor); }
bool BackEnd::optimization_due() const { return impl_->optimization_due(); }
std::shared_ptr<const OptimizationProblem> BackEnd::problem(bool thorough) const {
  return impl_->problem(thorough);
}
KeyFramePoses BackEnd::apply(const OptimizationSolution& solution) {
  return impl_->apply(solution);
}
KeyFramePoses BackEnd::poses() const { return impl_->poses(); }
Pose BackEnd::T_map_odom() const { return impl_->T_map_odom(); }
std::vector<std::pair<Loop, bool>> BackEnd::loops() const { return impl_->loops(); }
std::vector<int> BackEnd::parts() const { return impl_->parts(); }
PoseGraph BackEnd::graph() const { return impl_->graph(); }

}  // namespace lidar_mapping::back_end
