// SPDX-License-Identifier: BSD-3-Clause
#include "worlds/town_layout.hpp"

#include <cmath>

namespace lidar_mapping::simulation {

namespace {

/// Distance between streets that look alike, m. Chosen as between others (62 to 80 m).
constexpr double kEvenSpacing = 70.0;

/// A straight line in the plane with a direction.
struct Line {
  Eigen::Vector2d point;
  Eigen::Vector2d direction;
};

Eigen::Vector2d to_left(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// The line through a and b, moved to the left of its direction.
Line shifted_line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double left) {
  const Eigen::Vector2d direction = (b - a).normalized();
  return {a + left * to_left(direction), direction};
}

/// Intersection of two lines; `fallback` if they are nearly parallel.
Eigen::Vector2d intersection(const Line& a, const Line& b, const Eigen::Vector2d& fallback) {
  const double sine = a.direction.dot(to_left(b.direction));
  if (std::abs(sine) < 0.15) return fallback;
  return a.point + (b.point - a.point).dot(to_left(b.direction)) / sine * a.direction;
}

}  // namespace

TownLayout::TownLayout(int columns, int rows, bool rows_alike, Random random)
    : columns_(columns), rows_(rows), rows_alike_(rows_alike) {
  std::vector<double> xs(columns), ys(rows);
  for (int i = 1; i < columns; ++i) xs[i] = xs[i - 1] + random.uniform(72.0, 96.0);
  for (int j = 1; j < rows; ++j) {
    ys[j] = ys[j - 1] + (rows_alike ? kEvenSpacing : random.uniform(62.0, 80.0));
  }
  const double skew = rows_alike ? 0.0 : 4.5;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double dx = random.uniform(-skew, skew), dy = random.uniform(-skew, skew);
      nodes_.emplace_back(xs[i] + dx, ys[j] + dy);
    }
  }
  for (int i = 0; i < columns; ++i) column_half_widths_.push_back(random.uniform(5.6, 7.2));
  for (int j = 0; j < rows; ++j) row_half_widths_.push_back(random.uniform(5.6, 7.2));
  if (rows_alike) row_half_widths_.assign(rows, row_half_widths_.front());
}

std::array<Eigen::Vector2d, 4> TownLayout::block(Crossing at) const {
  const std::array<Eigen::Vector2d, 4> nodes = {crossing(at), crossing({at.column + 1, at.row}),
                                                crossing({at.column + 1, at.row + 1}),
                                                crossing({at.column, at.row + 1})};
  const std::array<double, 4> half_widths = {
      row_half_width(at.row), column_half_width(at.column + 1), row_half_width(at.row + 1),
      column_half_width(at.column)};
  std::array<Eigen::Vector2d, 4> corners;
  for (int i = 0; i < 4; ++i) {
    const int before = (i + 3) % 4;
    corners[i] = intersection(shifted_line(nodes[before], nodes[i], half_widths[before]),
                              shifted_line(nodes[i], nodes[(i + 1) % 4], half_widths[i]), nodes[i]);
  }
  return corners;
}

std::vector<Eigen::Vector2d> TownLayout::lane_corners(const std::vector<Crossing>& route,
                                                      double lane) const {
  const auto leg = [&](std::size_t i) {
    return shifted_line(crossing(route[i]), crossing(route[i + 1]), -lane);
  };
  std::vector<Eigen::Vector2d> corners = {leg(0).point};
  for (std::size_t i = 1; i + 1 < route.size(); ++i) {
    const Line before = leg(i - 1), after = leg(i);
    const Eigen::Vector2d straight_on =
        crossing(route[i]) - lane * to_left((before.direction + after.direction).normalized());
    corners.push_back(intersection(before, after, straight_on));
  }
  const Line last = leg(route.size() - 2);
  corners.push_back(crossing(route.back()) - lane * to_left(last.direction));
  return corners;
}

}  // namespace lidar_mapping::simulation
