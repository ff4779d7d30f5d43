// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/pose_graph/pose_graph.hpp"
#include "lidar_mapping/pose_graph/residuals.hpp"

namespace lidar_mapping::test {

/// A car that drives through a town of square blocks and turns at random, a key frame every metre.
struct StreetSettings {
  int key_frames = 1000;
  int loops = 200;       ///< spread evenly over the key frames that see an earlier place
  int blocks = 0;        ///< per side of the town; 0: each street is driven about 1.2 times
  double block = 100.0;  ///< m, side of a block, a whole number
  double hill = 3.0;     ///< m
  double odometry_stddev_m = 0.02;
  double odometry_stddev_deg = 0.02;
  double scale_error = 0.002;
  double turn_bias_deg = 0.001;  ///< per key frame, about z
  double loop_stddev_m = 0.06;
  double loop_stddev_deg = 0.2;
  unsigned seed = 1;
};

/// The graph of such a drive at the poses of odometry, with the true poses.
struct StreetGraph {
  pose_graph::PoseGraph graph;
  std::vector<Pose> truth;
};

/// Drives through the town key frame by key frame.
class StreetDriver {
 public:
  StreetDriver(const StreetSettings& settings, int blocks)
      : settings_(settings), blocks_(blocks), engine_(settings.seed) {
    next_direction_ = choose_direction();
  }

  Pose pose() const {
    constexpr std::array<double, 4> kX = {1.0, 0.0, -1.0, 0.0};
    constexpr std::array<double, 4> kY = {0.0, 1.0, 0.0, -1.0};
    const auto d = static_cast<std::size_t>(direction_);
    // Two metres right of the middle of the street.
    const double x = crossing_x_ * settings_.block + kX[d] * along_ + 2.0 * kY[d];
    const double y = crossing_y_ * settings_.block + kY[d] * along_ - 2.0 * kX[d];
    const double turn = std::remainder((next_direction_ - direction_) * M_PI / 2.0, 2.0 * M_PI);
    const double blend = std::max(0.0, (along_ - settings_.block + 10.0) / 10.0);
    const double z = settings_.hill * (std::sin(x / 60.0) + std::cos(y / 80.0));
    return {exp_so3({0.0, 0.0, direction_ * M_PI / 2.0 + blend * turn}), {x, y, z}};
  }

  /// Number of the metre of street, the same in both directions.
  std::int64_t place() const {
    const auto length = static_cast<std::int64_t>(settings_.block);
    const bool backward = direction_ >= 2;
    const auto x = static_cast<std::int64_t>(crossing_x_ - (direction_ == 2 ? 1 : 0));
    const auto y = static_cast<std::int64_t>(crossing_y_ - (direction_ == 3 ? 1 : 0));
    const auto metre = static_cast<std::int64_t>(along_);
    const std::int64_t street = 2 * (y * (blocks_ + 1) + x) + direction_ % 2;
    return street * length + (backward ? length - 1 - metre : metre);
  }

  std::int64_t places() const {
    return static_cast<std::int64_t>(2 * (blocks_ + 1) * (blocks_ + 1) * settings_.block);
  }

  void advance() {
    along_ += 1.0;
    if (along_ < settings_.block) return;
    along_ = 0.0;
    step(direction_, crossing_x_, crossing_y_);
    direction_ = next_direction_;
    next_direction_ = choose_direction();
  }

 private:
  static void step(int direction, int& x, int& y) {
    x += direction == 0 ? 1 : (direction == 2 ? -1 : 0);
    y += direction == 1 ? 1 : (direction == 3 ? -1 : 0);
  }

  /// Straight on, left or right at the next crossing, whichever stays in the town.
  int choose_direction() {
    int x = crossing_x_, y = crossing_y_;
    step(direction_, x, y);
    std::uniform_int_distribution<int> turn(-1, 1);
    while (true) {
      const int direction = (direction_ + turn(engine_) + 4) % 4;
      int next_x = x, next_y = y;
      step(direction, next_x, next_y);
      if (std::min(next_x, next_y) >= 0 && std::max(next_x, next_y) <= blocks_) return direction;
    }
  }

  StreetSettings settings_;
  int blocks_;
  std::mt19937 engine_;
  int crossing_x_ = 0, crossing_y_ = 0;
  int direction_ = 0;  ///< 0 to 3: east, north, west, south
  int next_direction_ = 0;
  double along_ = 0.0;  ///< m from the last crossing
};

/// A motion with noise.
inline Pose measured(const Pose& motion, std::mt19937& engine, double stddev_m, double stddev_deg) {
  std::normal_distribution<double> normal;
  Vector6d d;
  for (int i = 0; i < 6; ++i) {
    d[i] = normal(engine) * (i < 3 ? stddev_m : stddev_deg * M_PI / 180.0);
  }
  return perturbed(motion, d);
}

inline Matrix6d information_of(double stddev_m, double stddev_deg) {
  return pose_graph::g2o_information(diagonal_covariance(stddev_m, stddev_deg * M_PI / 180.0));
}

/// Makes the graph of a drive, the same one for the same settings.
inline StreetGraph make_street_graph(const StreetSettings& s) {
  // A town of n x n blocks has 2 n (n + 1) streets.
  const int blocks =
      s.blocks > 0
          ? s.blocks
          : std::max(2, static_cast<int>(std::lround(std::sqrt(s.key_frames / s.block / 2.4))));
  StreetDriver driver(s, blocks);
  std::mt19937 engine(s.seed + 1);
  StreetGraph result;
  result.truth.reserve(static_cast<std::size_t>(s.key_frames));
  std::vector<int> last_at(static_cast<std::size_t>(driver.places()), -1);
  std::vector<std::pair<int, int>> pairs;  // key frames that see one place
  constexpr int kApart = 50;
  for (int i = 0; i < s.key_frames; ++i) {
    result.truth.push_back(driver.pose());
    int& last = last_at[driver.place()];
    if (last >= 0 && i - last > kApart) pairs.emplace_back(last, i);
    last = i;
    driver.advance();
  }
  auto& nodes = result.graph.nodes;
  auto& edges = result.graph.edges;
  nodes.reserve(result.truth.size());
  edges.reserve(result.truth.size() + static_cast<std::size_t>(s.loops));
  const Matrix6d odometry = information_of(s.odometry_stddev_m, s.odometry_stddev_deg);
  const Matrix6d loop = information_of(s.loop_stddev_m, s.loop_stddev_deg);
  nodes.push_back({0, result.truth.front()});
  for (int i = 1; i < s.key_frames; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    Pose motion = result.truth[slot - 1].inverse() * result.truth[slot];
    motion.translation *= 1.0 + s.scale_error;
    motion = measured(motion, engine, s.odometry_stddev_m, s.odometry_stddev_deg);
    motion.rotation = motion.rotation * exp_so3({0.0, 0.0, s.turn_bias_deg * M_PI / 180.0});
    edges.push_back({i - 1, i, motion, odometry});
    nodes.push_back({i, nodes.back().pose * motion});
  }
  const auto wanted = std::min(pairs.size(), static_cast<std::size_t>(s.loops));
  std::uniform_int_distribution<int> shift(-2, 2);
  for (std::size_t k = 0; k < wanted; ++k) {
    auto [from, to] = pairs[k * pairs.size() / wanted];
    from = std::clamp(from + shift(engine), 0, to - kApart);
    const Pose motion = result.truth[from].inverse() * result.truth[to];
    edges.push_back({from, to, measured(motion, engine, s.loop_stddev_m, s.loop_stddev_deg), loop});
  }
  return result;
}

}  // namespace lidar_mapping::test
