// SPDX-License-Identifier: BSD-3-Clause
#include "mark_file.hpp"

namespace lidar_mapping::moving_objects {

namespace {

constexpr std::size_t kSize = sizeof(Marks::value_type);

}  // namespace

void MarkFile::put(std::size_t position, const Marks& marks) {
  if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
  file_->write(end_ * kSize, marks.data(), marks.size() * kSize);
  spans_[position] = {end_, marks.size()};
  end_ += marks.size();
}

Marks MarkFile::get(std::size_t position) const {
  const Span& span = spans_.at(position);
  Marks marks(span.count);
  file_->read(span.begin * kSize, marks.data(), marks.size() * kSize);
  return marks;
}

}  // namespace lidar_mapping::moving_objects
