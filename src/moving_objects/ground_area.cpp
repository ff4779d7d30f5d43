// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/moving_objects/ground_area.hpp"

#include <numeric>

namespace lidar_mapping::moving_objects {

namespace {

using Flags = std::vector<std::uint8_t>;

constexpr std::size_t kWindow = GroundArea::kWindow;  // columns

/// Logical or of kWindow flags each, which are `step` apart; the input is longer by their distance.
Flags dilated(const Flags& flags, std::size_t step) {
  Flags result(flags.size() - (kWindow - 1) * step);
  std::uint8_t* __restrict to = result.data();
  const std::uint8_t* from = flags.data();
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::uint8_t any = 0;
    for (std::size_t n = 0; n < kWindow; ++n) any |= from[i + n * step];
    to[i] = any;
  }
  return result;
}

}  // namespace

GroundArea::GroundArea(const PointCells& cells)
    : rectangle_(CellRectangle(cells).expanded(static_cast<int>(kMargin))),
      numbers_(rectangle_.size()),
      columns_of_points_(rectangle_.indices_of(cells)) {
  const std::size_t width = rectangle_.width();
  const std::size_t margin = kMargin * (width + 1);
  Flags occupied(rectangle_.size() + 2 * margin);
  for (const std::uint32_t cell : columns_of_points_) {
    if (cell != CellRectangle::kOutside) occupied[margin + cell] = 1;
  }
  // No flag is set at the edges, so that no row reaches into the next.
  const Flags near = dilated(dilated(occupied, 1), width);
  // One more, because cells that are not counted are written, too.
  cells_.resize(std::accumulate(near.begin(), near.end(), std::size_t{1}));
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    cells_[count] = static_cast<std::uint32_t>(i);
    numbers_[i] = near[i] != 0 ? count : kOutside;
    count += near[i];
  }
  cells_.resize(count);
  for (std::uint32_t& column : columns_of_points_) {
    if (column != kOutside) column = numbers_[column];
  }
}

std::array<std::uint32_t, GroundArea::kWindow> GroundArea::rows_around(std::uint32_t column) const {
  const std::size_t width = rectangle_.width();
  const std::size_t corner = cells_[column] - kMargin * (width + 1);
  std::array<std::uint32_t, kWindow> rows{};
  for (std::size_t row = 0; row < kWindow; ++row) rows[row] = numbers_[corner + row * width];
  return rows;
}

}  // namespace lidar_mapping::moving_objects
